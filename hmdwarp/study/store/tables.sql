-- No row keeps a date, a random word or a name of a participant who withdrew: `withdrawn` has only
-- the code. cleaned: whether the bytes are gone too. AUTOINCREMENT: ids are never reused, so that an
-- id in an old export cannot mean another participant's row. A declined or unconsented session is
-- 'stopped' in session.status; its journal tells (queries.py), as in the stores of older versions.
CREATE TABLE study (name TEXT NOT NULL, made_by TEXT NOT NULL) STRICT;
CREATE TABLE plan (id INTEGER PRIMARY KEY, text TEXT NOT NULL, meaning TEXT NOT NULL, UNIQUE (text, meaning)) STRICT;
CREATE TABLE participant (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE COLLATE NOCASE,
  sub TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('person', 'pilot', 'simulated')),
  withdrawing INTEGER NOT NULL DEFAULT 0
) STRICT;
CREATE TABLE session (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  participant INTEGER NOT NULL REFERENCES participant (id),
  number INTEGER NOT NULL CHECK (number >= 1),
  part TEXT NOT NULL,
  order_row INTEGER NOT NULL,
  order_names TEXT NOT NULL,
  plan INTEGER NOT NULL REFERENCES plan (id),
  status TEXT NOT NULL CHECK (status IN ('running', 'interrupted', 'complete', 'stopped', 'sick')),
  why TEXT NOT NULL DEFAULT '',
  started_utc TEXT NOT NULL,
  ended_utc TEXT NOT NULL DEFAULT '',
  facts TEXT NOT NULL,
  UNIQUE (participant, number)
) STRICT;
CREATE TABLE showing (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  key TEXT NOT NULL,
  trial INTEGER NOT NULL,
  repeat INTEGER NOT NULL,
  condition TEXT NOT NULL,
  presentation INTEGER NOT NULL CHECK (presentation >= 1),
  complete INTEGER NOT NULL DEFAULT 0 CHECK (complete IN (0, 1)),
  settings TEXT NOT NULL,
  trace TEXT NOT NULL,
  actual TEXT NOT NULL DEFAULT '{}',
  measured TEXT NOT NULL DEFAULT '{}',
  started_utc TEXT NOT NULL,
  UNIQUE (session, key, presentation)
) STRICT;
CREATE TABLE answer (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  key TEXT NOT NULL,
  revision INTEGER NOT NULL CHECK (revision >= 1),
  phase TEXT NOT NULL,
  trial INTEGER NOT NULL,
  scale TEXT NOT NULL,
  item TEXT NOT NULL,
  value REAL,
  seconds REAL NOT NULL,
  answered_by TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  showing INTEGER REFERENCES showing (id),
  UNIQUE (session, key, revision)
) STRICT;
CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  kind TEXT NOT NULL,
  key TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  mono_ns INTEGER NOT NULL,
  data TEXT NOT NULL
) STRICT;
CREATE INDEX event_of_session ON event (session, kind);
CREATE TABLE withdrawn (code TEXT NOT NULL PRIMARY KEY COLLATE NOCASE, cleaned INTEGER NOT NULL) STRICT;
