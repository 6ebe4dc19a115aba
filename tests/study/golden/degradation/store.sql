PRAGMA application_id = 1751999607;
PRAGMA user_version = 1;
BEGIN TRANSACTION;
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
INSERT INTO "answer" VALUES(1,1,'trial/1/dcr/impairment',1,'trial',1,'dcr','impairment',1.0,0.5,'experimenter','2031-07-23T16:41:29.143Z',2);
INSERT INTO "answer" VALUES(2,1,'trial/1/dcr/impairment',2,'trial',1,'dcr','impairment',5.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:33.169Z',2);
INSERT INTO "answer" VALUES(3,1,'trial/2/dcr/impairment',1,'trial',2,'dcr','impairment',4.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:49.273Z',4);
INSERT INTO "answer" VALUES(4,1,'trial/3/dcr/impairment',1,'trial',3,'dcr','impairment',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:05.377Z',6);
INSERT INTO "answer" VALUES(5,1,'trial/4/dcr/impairment',1,'trial',4,'dcr','impairment',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:21.481Z',8);
INSERT INTO "answer" VALUES(6,1,'trial/5/dcr/impairment',1,'trial',5,'dcr','impairment',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:37.585Z',10);
INSERT INTO "answer" VALUES(7,1,'after/ipq/being_there',1,'after',0,'ipq','being_there',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:41.611Z',NULL);
INSERT INTO "answer" VALUES(8,1,'after/ipq/surrounded',1,'after',0,'ipq','surrounded',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:45.637Z',NULL);
INSERT INTO "answer" VALUES(9,1,'after/ipq/pictures',1,'after',0,'ipq','pictures',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:49.663Z',NULL);
INSERT INTO "answer" VALUES(10,1,'after/ipq/not_present',1,'after',0,'ipq','not_present',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:53.689Z',NULL);
INSERT INTO "answer" VALUES(11,1,'after/ipq/acting',1,'after',0,'ipq','acting',5.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:57.715Z',NULL);
INSERT INTO "answer" VALUES(12,1,'after/ipq/present',1,'after',0,'ipq','present',4.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:01.741Z',NULL);
INSERT INTO "answer" VALUES(13,1,'after/ipq/aware',1,'after',0,'ipq','aware',6.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:05.767Z',NULL);
INSERT INTO "answer" VALUES(14,1,'after/ipq/unaware',1,'after',0,'ipq','unaware',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:09.793Z',NULL);
INSERT INTO "answer" VALUES(15,1,'after/ipq/attention',1,'after',0,'ipq','attention',4.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:13.819Z',NULL);
INSERT INTO "answer" VALUES(16,1,'after/ipq/captivated',1,'after',0,'ipq','captivated',6.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:17.845Z',NULL);
INSERT INTO "answer" VALUES(17,1,'after/ipq/real',1,'after',0,'ipq','real',5.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:21.871Z',NULL);
INSERT INTO "answer" VALUES(18,1,'after/ipq/consistent',1,'after',0,'ipq','consistent',4.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:25.897Z',NULL);
INSERT INTO "answer" VALUES(19,1,'after/ipq/imagined',1,'after',0,'ipq','imagined',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:29.923Z',NULL);
INSERT INTO "answer" VALUES(20,1,'after/ipq/more_real',1,'after',0,'ipq','more_real',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:33.949Z',NULL);
INSERT INTO "answer" VALUES(21,1,'after/ssq/general_discomfort',1,'after',0,'ssq','general_discomfort',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:37.975Z',NULL);
INSERT INTO "answer" VALUES(22,1,'after/ssq/fatigue',1,'after',0,'ssq','fatigue',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:42.001Z',NULL);
INSERT INTO "answer" VALUES(23,1,'after/ssq/headache',1,'after',0,'ssq','headache',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:46.027Z',NULL);
INSERT INTO "answer" VALUES(24,1,'after/ssq/eyestrain',1,'after',0,'ssq','eyestrain',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:50.053Z',NULL);
INSERT INTO "answer" VALUES(25,1,'after/ssq/difficulty_focusing',1,'after',0,'ssq','difficulty_focusing',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:54.079Z',NULL);
INSERT INTO "answer" VALUES(26,1,'after/ssq/increased_salivation',1,'after',0,'ssq','increased_salivation',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:58.105Z',NULL);
INSERT INTO "answer" VALUES(27,1,'after/ssq/sweating',1,'after',0,'ssq','sweating',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:02.131Z',NULL);
INSERT INTO "answer" VALUES(28,1,'after/ssq/nausea',1,'after',0,'ssq','nausea',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:06.157Z',NULL);
INSERT INTO "answer" VALUES(29,1,'after/ssq/difficulty_concentrating',1,'after',0,'ssq','difficulty_concentrating',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:10.183Z',NULL);
INSERT INTO "answer" VALUES(30,1,'after/ssq/fullness_of_head',1,'after',0,'ssq','fullness_of_head',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:14.209Z',NULL);
INSERT INTO "answer" VALUES(31,1,'after/ssq/blurred_vision',1,'after',0,'ssq','blurred_vision',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:18.235Z',NULL);
INSERT INTO "answer" VALUES(32,1,'after/ssq/dizzy_eyes_open',1,'after',0,'ssq','dizzy_eyes_open',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:22.261Z',NULL);
INSERT INTO "answer" VALUES(33,1,'after/ssq/dizzy_eyes_closed',1,'after',0,'ssq','dizzy_eyes_closed',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:26.287Z',NULL);
INSERT INTO "answer" VALUES(34,1,'after/ssq/vertigo',1,'after',0,'ssq','vertigo',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:30.313Z',NULL);
INSERT INTO "answer" VALUES(35,1,'after/ssq/stomach_awareness',1,'after',0,'ssq','stomach_awareness',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:34.339Z',NULL);
INSERT INTO "answer" VALUES(36,1,'after/ssq/burping',1,'after',0,'ssq','burping',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:38.365Z',NULL);
INSERT INTO "answer" VALUES(37,2,'trial/1/dcr/impairment',1,'trial',1,'dcr','impairment',1.0,0.5,'participant','2031-07-23T16:45:06.547Z',12);
INSERT INTO "answer" VALUES(38,2,'trial/1/dcr/impairment',2,'trial',1,'dcr','impairment',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:10.573Z',12);
INSERT INTO "answer" VALUES(39,2,'trial/2/dcr/impairment',1,'trial',2,'dcr','impairment',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:45:26.677Z',14);
INSERT INTO "answer" VALUES(40,2,'trial/3/dcr/impairment',1,'trial',3,'dcr','impairment',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:42.781Z',16);
INSERT INTO "answer" VALUES(41,2,'trial/4/dcr/impairment',1,'trial',4,'dcr','impairment',5.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:58.885Z',18);
INSERT INTO "answer" VALUES(42,2,'trial/5/dcr/impairment',1,'trial',5,'dcr','impairment',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:14.989Z',20);
INSERT INTO "answer" VALUES(43,2,'after/ipq/being_there',1,'after',0,'ipq','being_there',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:19.015Z',NULL);
INSERT INTO "answer" VALUES(44,2,'after/ipq/surrounded',1,'after',0,'ipq','surrounded',5.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:23.041Z',NULL);
INSERT INTO "answer" VALUES(45,2,'after/ipq/pictures',1,'after',0,'ipq','pictures',6.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:27.067Z',NULL);
INSERT INTO "answer" VALUES(46,2,'after/ipq/not_present',1,'after',0,'ipq','not_present',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:31.093Z',NULL);
INSERT INTO "answer" VALUES(47,2,'after/ipq/acting',1,'after',0,'ipq','acting',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:35.119Z',NULL);
INSERT INTO "answer" VALUES(48,2,'after/ipq/present',1,'after',0,'ipq','present',6.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:39.145Z',NULL);
INSERT INTO "answer" VALUES(49,2,'after/ipq/aware',1,'after',0,'ipq','aware',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:43.171Z',NULL);
INSERT INTO "answer" VALUES(50,2,'after/ipq/unaware',1,'after',0,'ipq','unaware',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:47.197Z',NULL);
INSERT INTO "answer" VALUES(51,2,'after/ipq/attention',1,'after',0,'ipq','attention',5.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:51.223Z',NULL);
INSERT INTO "answer" VALUES(52,2,'after/ipq/captivated',1,'after',0,'ipq','captivated',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:55.249Z',NULL);
INSERT INTO "answer" VALUES(53,2,'after/ipq/real',1,'after',0,'ipq','real',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:59.275Z',NULL);
INSERT INTO "answer" VALUES(54,2,'after/ipq/consistent',1,'after',0,'ipq','consistent',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:03.301Z',NULL);
INSERT INTO "answer" VALUES(55,2,'after/ipq/imagined',1,'after',0,'ipq','imagined',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:07.327Z',NULL);
INSERT INTO "answer" VALUES(56,2,'after/ipq/more_real',1,'after',0,'ipq','more_real',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:11.353Z',NULL);
INSERT INTO "answer" VALUES(57,2,'after/ssq/general_discomfort',1,'after',0,'ssq','general_discomfort',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:15.379Z',NULL);
INSERT INTO "answer" VALUES(58,2,'after/ssq/fatigue',1,'after',0,'ssq','fatigue',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:19.405Z',NULL);
INSERT INTO "answer" VALUES(59,2,'after/ssq/headache',1,'after',0,'ssq','headache',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:23.431Z',NULL);
INSERT INTO "answer" VALUES(60,2,'after/ssq/eyestrain',1,'after',0,'ssq','eyestrain',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:27.457Z',NULL);
INSERT INTO "answer" VALUES(61,2,'after/ssq/difficulty_focusing',1,'after',0,'ssq','difficulty_focusing',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:31.483Z',NULL);
INSERT INTO "answer" VALUES(62,2,'after/ssq/increased_salivation',1,'after',0,'ssq','increased_salivation',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:35.509Z',NULL);
INSERT INTO "answer" VALUES(63,2,'after/ssq/sweating',1,'after',0,'ssq','sweating',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:39.535Z',NULL);
INSERT INTO "answer" VALUES(64,2,'after/ssq/nausea',1,'after',0,'ssq','nausea',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:43.561Z',NULL);
INSERT INTO "answer" VALUES(65,2,'after/ssq/difficulty_concentrating',1,'after',0,'ssq','difficulty_concentrating',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:47.587Z',NULL);
INSERT INTO "answer" VALUES(66,2,'after/ssq/fullness_of_head',1,'after',0,'ssq','fullness_of_head',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:51.613Z',NULL);
INSERT INTO "answer" VALUES(67,2,'after/ssq/blurred_vision',1,'after',0,'ssq','blurred_vision',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:55.639Z',NULL);
INSERT INTO "answer" VALUES(68,2,'after/ssq/dizzy_eyes_open',1,'after',0,'ssq','dizzy_eyes_open',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:59.665Z',NULL);
INSERT INTO "answer" VALUES(69,2,'after/ssq/dizzy_eyes_closed',1,'after',0,'ssq','dizzy_eyes_closed',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:48:03.691Z',NULL);
INSERT INTO "answer" VALUES(70,2,'after/ssq/vertigo',1,'after',0,'ssq','vertigo',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:48:07.717Z',NULL);
INSERT INTO "answer" VALUES(71,2,'after/ssq/stomach_awareness',1,'after',0,'ssq','stomach_awareness',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:48:11.743Z',NULL);
INSERT INTO "answer" VALUES(72,2,'after/ssq/burping',1,'after',0,'ssq','burping',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:48:15.769Z',NULL);
INSERT INTO "answer" VALUES(73,3,'trial/1/dcr/impairment',1,'trial',1,'dcr','impairment',1.0,0.5,'participant','2031-07-23T16:48:43.951Z',22);
INSERT INTO "answer" VALUES(74,3,'trial/1/dcr/impairment',2,'trial',1,'dcr','impairment',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:47.977Z',22);
INSERT INTO "answer" VALUES(75,3,'trial/2/dcr/impairment',1,'trial',2,'dcr','impairment',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:04.081Z',24);
INSERT INTO "answer" VALUES(76,3,'trial/3/dcr/impairment',1,'trial',3,'dcr','impairment',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:20.185Z',26);
INSERT INTO "answer" VALUES(77,3,'trial/4/dcr/impairment',1,'trial',4,'dcr','impairment',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:36.289Z',28);
INSERT INTO "answer" VALUES(78,3,'trial/5/dcr/impairment',1,'trial',5,'dcr','impairment',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:52.393Z',30);
INSERT INTO "answer" VALUES(79,3,'after/ipq/being_there',1,'after',0,'ipq','being_there',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:56.419Z',NULL);
INSERT INTO "answer" VALUES(80,3,'after/ipq/surrounded',1,'after',0,'ipq','surrounded',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:00.445Z',NULL);
INSERT INTO "answer" VALUES(81,3,'after/ipq/pictures',1,'after',0,'ipq','pictures',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:04.471Z',NULL);
INSERT INTO "answer" VALUES(82,3,'after/ipq/not_present',1,'after',0,'ipq','not_present',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:08.497Z',NULL);
INSERT INTO "answer" VALUES(83,3,'after/ipq/acting',1,'after',0,'ipq','acting',4.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:12.523Z',NULL);
INSERT INTO "answer" VALUES(84,3,'after/ipq/present',1,'after',0,'ipq','present',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:16.549Z',NULL);
INSERT INTO "answer" VALUES(85,3,'after/ipq/aware',1,'after',0,'ipq','aware',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:20.575Z',NULL);
INSERT INTO "answer" VALUES(86,3,'after/ipq/unaware',1,'after',0,'ipq','unaware',6.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:24.601Z',NULL);
INSERT INTO "answer" VALUES(87,3,'after/ipq/attention',1,'after',0,'ipq','attention',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:28.627Z',NULL);
INSERT INTO "answer" VALUES(88,3,'after/ipq/captivated',1,'after',0,'ipq','captivated',6.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:32.653Z',NULL);
INSERT INTO "answer" VALUES(89,3,'after/ipq/real',1,'after',0,'ipq','real',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:36.679Z',NULL);
INSERT INTO "answer" VALUES(90,3,'after/ipq/consistent',1,'after',0,'ipq','consistent',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:40.705Z',NULL);
INSERT INTO "answer" VALUES(91,3,'after/ipq/imagined',1,'after',0,'ipq','imagined',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:44.731Z',NULL);
INSERT INTO "answer" VALUES(92,3,'after/ipq/more_real',1,'after',0,'ipq','more_real',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:48.757Z',NULL);
INSERT INTO "answer" VALUES(93,3,'after/ssq/general_discomfort',1,'after',0,'ssq','general_discomfort',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:52.783Z',NULL);
INSERT INTO "answer" VALUES(94,3,'after/ssq/fatigue',1,'after',0,'ssq','fatigue',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:56.809Z',NULL);
INSERT INTO "answer" VALUES(95,3,'after/ssq/headache',1,'after',0,'ssq','headache',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:00.835Z',NULL);
INSERT INTO "answer" VALUES(96,3,'after/ssq/eyestrain',1,'after',0,'ssq','eyestrain',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:04.861Z',NULL);
INSERT INTO "answer" VALUES(97,3,'after/ssq/difficulty_focusing',1,'after',0,'ssq','difficulty_focusing',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:08.887Z',NULL);
INSERT INTO "answer" VALUES(98,3,'after/ssq/increased_salivation',1,'after',0,'ssq','increased_salivation',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:12.913Z',NULL);
INSERT INTO "answer" VALUES(99,3,'after/ssq/sweating',1,'after',0,'ssq','sweating',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:16.939Z',NULL);
INSERT INTO "answer" VALUES(100,3,'after/ssq/nausea',1,'after',0,'ssq','nausea',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:20.965Z',NULL);
INSERT INTO "answer" VALUES(101,3,'after/ssq/difficulty_concentrating',1,'after',0,'ssq','difficulty_concentrating',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:24.991Z',NULL);
INSERT INTO "answer" VALUES(102,3,'after/ssq/fullness_of_head',1,'after',0,'ssq','fullness_of_head',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:29.017Z',NULL);
INSERT INTO "answer" VALUES(103,3,'after/ssq/blurred_vision',1,'after',0,'ssq','blurred_vision',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:33.043Z',NULL);
INSERT INTO "answer" VALUES(104,3,'after/ssq/dizzy_eyes_open',1,'after',0,'ssq','dizzy_eyes_open',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:37.069Z',NULL);
INSERT INTO "answer" VALUES(105,3,'after/ssq/dizzy_eyes_closed',1,'after',0,'ssq','dizzy_eyes_closed',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:41.095Z',NULL);
INSERT INTO "answer" VALUES(106,3,'after/ssq/vertigo',1,'after',0,'ssq','vertigo',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:45.121Z',NULL);
INSERT INTO "answer" VALUES(107,3,'after/ssq/stomach_awareness',1,'after',0,'ssq','stomach_awareness',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:49.147Z',NULL);
INSERT INTO "answer" VALUES(108,3,'after/ssq/burping',1,'after',0,'ssq','burping',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:51:53.173Z',NULL);
INSERT INTO "answer" VALUES(109,4,'trial/1/dcr/impairment',1,'trial',1,'dcr','impairment',1.0,0.5,'participant','2031-07-23T16:52:27.394Z',33);
INSERT INTO "answer" VALUES(110,4,'trial/1/dcr/impairment',2,'trial',1,'dcr','impairment',5.0,4.650000033,'participant','2031-07-23T16:52:31.420Z',33);
INSERT INTO "answer" VALUES(111,4,'trial/2/dcr/impairment',1,'trial',2,'dcr','impairment',1.0,4.650000033,'participant','2031-07-23T16:52:47.524Z',35);
INSERT INTO "answer" VALUES(112,4,'trial/3/dcr/impairment',1,'trial',3,'dcr','impairment',1.0,4.650000033,'participant','2031-07-23T16:53:03.628Z',37);
INSERT INTO "answer" VALUES(113,4,'trial/4/dcr/impairment',1,'trial',4,'dcr','impairment',2.0,4.650000033,'participant','2031-07-23T16:53:19.732Z',39);
INSERT INTO "answer" VALUES(114,4,'trial/5/dcr/impairment',1,'trial',5,'dcr','impairment',1.0,4.650000033,'participant','2031-07-23T16:53:35.836Z',41);
INSERT INTO "answer" VALUES(115,4,'after/ipq/being_there',1,'after',0,'ipq','being_there',5.0,4.650000033,'participant','2031-07-23T16:53:39.862Z',NULL);
INSERT INTO "answer" VALUES(116,4,'after/ipq/surrounded',1,'after',0,'ipq','surrounded',6.0,4.650000033,'participant','2031-07-23T16:53:43.888Z',NULL);
INSERT INTO "answer" VALUES(117,4,'after/ipq/pictures',1,'after',0,'ipq','pictures',4.0,4.650000033,'participant','2031-07-23T16:53:47.914Z',NULL);
INSERT INTO "answer" VALUES(118,4,'after/ipq/not_present',1,'after',0,'ipq','not_present',0.0,4.650000033,'participant','2031-07-23T16:53:51.940Z',NULL);
INSERT INTO "answer" VALUES(119,4,'after/ipq/acting',1,'after',0,'ipq','acting',0.0,4.650000033,'participant','2031-07-23T16:53:55.966Z',NULL);
INSERT INTO "answer" VALUES(120,4,'after/ipq/present',1,'after',0,'ipq','present',2.0,4.650000033,'participant','2031-07-23T16:53:59.992Z',NULL);
INSERT INTO "answer" VALUES(121,4,'after/ipq/aware',1,'after',0,'ipq','aware',3.0,4.650000033,'participant','2031-07-23T16:54:04.018Z',NULL);
INSERT INTO "answer" VALUES(122,4,'after/ipq/unaware',1,'after',0,'ipq','unaware',4.0,4.650000033,'participant','2031-07-23T16:54:08.044Z',NULL);
INSERT INTO "answer" VALUES(123,4,'after/ipq/attention',1,'after',0,'ipq','attention',3.0,4.650000033,'participant','2031-07-23T16:54:12.070Z',NULL);
INSERT INTO "answer" VALUES(124,4,'after/ipq/captivated',1,'after',0,'ipq','captivated',1.0,4.650000033,'participant','2031-07-23T16:54:16.096Z',NULL);
INSERT INTO "answer" VALUES(125,4,'after/ipq/real',1,'after',0,'ipq','real',1.0,4.650000033,'participant','2031-07-23T16:54:20.122Z',NULL);
INSERT INTO "answer" VALUES(126,4,'after/ipq/consistent',1,'after',0,'ipq','consistent',4.0,4.650000033,'participant','2031-07-23T16:54:24.148Z',NULL);
INSERT INTO "answer" VALUES(127,4,'after/ipq/imagined',1,'after',0,'ipq','imagined',5.0,4.650000033,'participant','2031-07-23T16:54:28.174Z',NULL);
INSERT INTO "answer" VALUES(128,4,'after/ipq/more_real',1,'after',0,'ipq','more_real',0.0,4.650000033,'participant','2031-07-23T16:54:32.200Z',NULL);
INSERT INTO "answer" VALUES(129,4,'after/ssq/general_discomfort',1,'after',0,'ssq','general_discomfort',0.0,4.650000033,'participant','2031-07-23T16:54:36.226Z',NULL);
INSERT INTO "answer" VALUES(130,4,'after/ssq/fatigue',1,'after',0,'ssq','fatigue',1.0,4.650000033,'participant','2031-07-23T16:54:40.252Z',NULL);
INSERT INTO "answer" VALUES(131,4,'after/ssq/headache',1,'after',0,'ssq','headache',1.0,4.650000033,'participant','2031-07-23T16:54:44.278Z',NULL);
INSERT INTO "answer" VALUES(132,4,'after/ssq/eyestrain',1,'after',0,'ssq','eyestrain',3.0,4.650000033,'participant','2031-07-23T16:54:48.304Z',NULL);
INSERT INTO "answer" VALUES(133,4,'after/ssq/difficulty_focusing',1,'after',0,'ssq','difficulty_focusing',2.0,4.650000033,'participant','2031-07-23T16:54:52.330Z',NULL);
INSERT INTO "answer" VALUES(134,4,'after/ssq/increased_salivation',1,'after',0,'ssq','increased_salivation',1.0,4.650000033,'participant','2031-07-23T16:54:56.356Z',NULL);
INSERT INTO "answer" VALUES(135,4,'after/ssq/sweating',1,'after',0,'ssq','sweating',1.0,4.650000033,'participant','2031-07-23T16:55:00.382Z',NULL);
INSERT INTO "answer" VALUES(136,4,'after/ssq/nausea',1,'after',0,'ssq','nausea',2.0,4.650000033,'participant','2031-07-23T16:55:04.408Z',NULL);
INSERT INTO "answer" VALUES(137,4,'after/ssq/difficulty_concentrating',1,'after',0,'ssq','difficulty_concentrating',2.0,4.650000033,'participant','2031-07-23T16:55:08.434Z',NULL);
INSERT INTO "answer" VALUES(138,4,'after/ssq/fullness_of_head',1,'after',0,'ssq','fullness_of_head',0.0,4.650000033,'participant','2031-07-23T16:55:12.460Z',NULL);
INSERT INTO "answer" VALUES(139,4,'after/ssq/blurred_vision',1,'after',0,'ssq','blurred_vision',2.0,4.650000033,'participant','2031-07-23T16:55:16.486Z',NULL);
INSERT INTO "answer" VALUES(140,4,'after/ssq/dizzy_eyes_open',1,'after',0,'ssq','dizzy_eyes_open',3.0,4.650000033,'participant','2031-07-23T16:55:20.512Z',NULL);
INSERT INTO "answer" VALUES(141,4,'after/ssq/dizzy_eyes_closed',1,'after',0,'ssq','dizzy_eyes_closed',3.0,4.650000033,'participant','2031-07-23T16:55:24.538Z',NULL);
INSERT INTO "answer" VALUES(142,4,'after/ssq/vertigo',1,'after',0,'ssq','vertigo',3.0,4.650000033,'participant','2031-07-23T16:55:28.564Z',NULL);
INSERT INTO "answer" VALUES(143,4,'after/ssq/stomach_awareness',1,'after',0,'ssq','stomach_awareness',1.0,4.650000033,'participant','2031-07-23T16:55:32.590Z',NULL);
INSERT INTO "answer" VALUES(144,4,'after/ssq/burping',1,'after',0,'ssq','burping',1.0,4.650000033,'participant','2031-07-23T16:55:36.616Z',NULL);
INSERT INTO "answer" VALUES(145,5,'trial/1/dcr/impairment',1,'trial',1,'dcr','impairment',1.0,0.5,'participant','2031-07-23T16:56:04.798Z',43);
INSERT INTO "answer" VALUES(146,5,'trial/1/dcr/impairment',2,'trial',1,'dcr','impairment',4.0,5.650000033,'participant','2031-07-23T16:56:08.824Z',43);
INSERT INTO "answer" VALUES(147,5,'trial/2/dcr/impairment',1,'trial',2,'dcr','impairment',5.0,5.650000033,'participant','2031-07-23T16:56:24.928Z',45);
INSERT INTO "answer" VALUES(148,5,'trial/3/dcr/impairment',1,'trial',3,'dcr','impairment',5.0,5.650000033,'participant','2031-07-23T16:56:41.032Z',47);
INSERT INTO "answer" VALUES(149,5,'trial/4/dcr/impairment',1,'trial',4,'dcr','impairment',3.0,5.650000033,'participant','2031-07-23T16:56:57.136Z',49);
INSERT INTO "answer" VALUES(150,5,'trial/5/dcr/impairment',1,'trial',5,'dcr','impairment',5.0,5.650000033,'participant','2031-07-23T16:57:13.240Z',51);
INSERT INTO "answer" VALUES(151,5,'after/ipq/being_there',1,'after',0,'ipq','being_there',6.0,5.650000033,'participant','2031-07-23T16:57:17.266Z',NULL);
INSERT INTO "answer" VALUES(152,5,'after/ipq/surrounded',1,'after',0,'ipq','surrounded',6.0,5.650000033,'participant','2031-07-23T16:57:21.292Z',NULL);
INSERT INTO "answer" VALUES(153,5,'after/ipq/pictures',1,'after',0,'ipq','pictures',0.0,5.650000033,'participant','2031-07-23T16:57:25.318Z',NULL);
INSERT INTO "answer" VALUES(154,5,'after/ipq/not_present',1,'after',0,'ipq','not_present',3.0,5.650000033,'participant','2031-07-23T16:57:29.344Z',NULL);
INSERT INTO "answer" VALUES(155,5,'after/ipq/acting',1,'after',0,'ipq','acting',4.0,5.650000033,'participant','2031-07-23T16:57:33.370Z',NULL);
INSERT INTO "answer" VALUES(156,5,'after/ipq/present',1,'after',0,'ipq','present',1.0,5.650000033,'participant','2031-07-23T16:57:37.396Z',NULL);
INSERT INTO "answer" VALUES(157,5,'after/ipq/aware',1,'after',0,'ipq','aware',2.0,5.650000033,'participant','2031-07-23T16:57:41.422Z',NULL);
INSERT INTO "answer" VALUES(158,5,'after/ipq/unaware',1,'after',0,'ipq','unaware',4.0,5.650000033,'participant','2031-07-23T16:57:45.448Z',NULL);
INSERT INTO "answer" VALUES(159,5,'after/ipq/attention',1,'after',0,'ipq','attention',5.0,5.650000033,'participant','2031-07-23T16:57:49.474Z',NULL);
INSERT INTO "answer" VALUES(160,5,'after/ipq/captivated',1,'after',0,'ipq','captivated',4.0,5.650000033,'participant','2031-07-23T16:57:53.500Z',NULL);
INSERT INTO "answer" VALUES(161,5,'after/ipq/real',1,'after',0,'ipq','real',1.0,5.650000033,'participant','2031-07-23T16:57:57.526Z',NULL);
INSERT INTO "answer" VALUES(162,5,'after/ipq/consistent',1,'after',0,'ipq','consistent',4.0,5.650000033,'participant','2031-07-23T16:58:01.552Z',NULL);
INSERT INTO "answer" VALUES(163,5,'after/ipq/imagined',1,'after',0,'ipq','imagined',6.0,5.650000033,'participant','2031-07-23T16:58:05.578Z',NULL);
INSERT INTO "answer" VALUES(164,5,'after/ipq/more_real',1,'after',0,'ipq','more_real',1.0,5.650000033,'participant','2031-07-23T16:58:09.604Z',NULL);
INSERT INTO "answer" VALUES(165,5,'after/ssq/general_discomfort',1,'after',0,'ssq','general_discomfort',2.0,5.650000033,'participant','2031-07-23T16:58:13.630Z',NULL);
INSERT INTO "answer" VALUES(166,5,'after/ssq/fatigue',1,'after',0,'ssq','fatigue',1.0,5.650000033,'participant','2031-07-23T16:58:17.656Z',NULL);
INSERT INTO "answer" VALUES(167,5,'after/ssq/headache',1,'after',0,'ssq','headache',3.0,5.650000033,'participant','2031-07-23T16:58:21.682Z',NULL);
INSERT INTO "answer" VALUES(168,5,'after/ssq/eyestrain',1,'after',0,'ssq','eyestrain',0.0,5.650000033,'participant','2031-07-23T16:58:25.708Z',NULL);
INSERT INTO "answer" VALUES(169,5,'after/ssq/difficulty_focusing',1,'after',0,'ssq','difficulty_focusing',1.0,5.650000033,'participant','2031-07-23T16:58:29.734Z',NULL);
INSERT INTO "answer" VALUES(170,5,'after/ssq/increased_salivation',1,'after',0,'ssq','increased_salivation',3.0,5.650000033,'participant','2031-07-23T16:58:33.760Z',NULL);
INSERT INTO "answer" VALUES(171,5,'after/ssq/sweating',1,'after',0,'ssq','sweating',1.0,5.650000033,'participant','2031-07-23T16:58:37.786Z',NULL);
INSERT INTO "answer" VALUES(172,5,'after/ssq/nausea',1,'after',0,'ssq','nausea',0.0,5.650000033,'participant','2031-07-23T16:58:41.812Z',NULL);
INSERT INTO "answer" VALUES(173,5,'after/ssq/difficulty_concentrating',1,'after',0,'ssq','difficulty_concentrating',3.0,5.650000033,'participant','2031-07-23T16:58:45.838Z',NULL);
INSERT INTO "answer" VALUES(174,5,'after/ssq/fullness_of_head',1,'after',0,'ssq','fullness_of_head',3.0,5.650000033,'participant','2031-07-23T16:58:49.864Z',NULL);
INSERT INTO "answer" VALUES(175,5,'after/ssq/blurred_vision',1,'after',0,'ssq','blurred_vision',3.0,5.650000033,'participant','2031-07-23T16:58:53.890Z',NULL);
INSERT INTO "answer" VALUES(176,5,'after/ssq/dizzy_eyes_open',1,'after',0,'ssq','dizzy_eyes_open',3.0,5.650000033,'participant','2031-07-23T16:58:57.916Z',NULL);
INSERT INTO "answer" VALUES(177,5,'after/ssq/dizzy_eyes_closed',1,'after',0,'ssq','dizzy_eyes_closed',1.0,5.650000033,'participant','2031-07-23T16:59:01.942Z',NULL);
INSERT INTO "answer" VALUES(178,5,'after/ssq/vertigo',1,'after',0,'ssq','vertigo',2.0,5.650000033,'participant','2031-07-23T16:59:05.968Z',NULL);
INSERT INTO "answer" VALUES(179,5,'after/ssq/stomach_awareness',1,'after',0,'ssq','stomach_awareness',3.0,5.650000033,'participant','2031-07-23T16:59:09.994Z',NULL);
INSERT INTO "answer" VALUES(180,5,'after/ssq/burping',1,'after',0,'ssq','burping',2.0,5.650000033,'participant','2031-07-23T16:59:14.020Z',NULL);
INSERT INTO "answer" VALUES(181,6,'trial/1/dcr/impairment',1,'trial',1,'dcr','impairment',1.0,0.5,'participant','2031-07-23T16:59:42.202Z',53);
INSERT INTO "answer" VALUES(182,6,'trial/1/dcr/impairment',2,'trial',1,'dcr','impairment',3.0,10.650000033,'participant','2031-07-23T16:59:46.228Z',53);
INSERT INTO "answer" VALUES(183,6,'trial/2/dcr/impairment',1,'trial',2,'dcr','impairment',5.0,10.650000033,'participant','2031-07-23T17:00:02.332Z',55);
INSERT INTO "answer" VALUES(184,6,'trial/3/dcr/impairment',1,'trial',3,'dcr','impairment',5.0,10.650000033,'participant','2031-07-23T17:00:18.436Z',57);
CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  kind TEXT NOT NULL,
  key TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  mono_ns INTEGER NOT NULL,
  data TEXT NOT NULL
) STRICT;
INSERT INTO "event" VALUES(1,1,'begin','','2031-07-23T16:41:13.039Z',2013000000,'{"part":"main","row":712,"plan_text_changed":false}');
INSERT INTO "event" VALUES(2,1,'finished','instructions','2031-07-23T16:41:15.052Z',4026000000,'{}');
INSERT INTO "event" VALUES(3,1,'showing','trial/1/reference','2031-07-23T16:41:19.078Z',6039000000,'{"showing":1,"presentation":1}');
INSERT INTO "event" VALUES(4,1,'shown','trial/1/reference','2031-07-23T16:41:21.091Z',8052000000,'{"showing":1,"complete":true}');
INSERT INTO "event" VALUES(5,1,'showing','trial/1/second','2031-07-23T16:41:25.117Z',10065000000,'{"showing":2,"presentation":1}');
INSERT INTO "event" VALUES(6,1,'shown','trial/1/second','2031-07-23T16:41:27.130Z',12078000000,'{"showing":2,"complete":true}');
INSERT INTO "event" VALUES(7,1,'answer','trial/1/dcr/impairment','2031-07-23T16:41:31.156Z',14091000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(8,1,'answer','trial/1/dcr/impairment','2031-07-23T16:41:35.182Z',16104000000,'{"value":5.0,"revision":2}');
INSERT INTO "event" VALUES(9,1,'showing','trial/2/reference','2031-07-23T16:41:39.208Z',18117000000,'{"showing":3,"presentation":1}');
INSERT INTO "event" VALUES(10,1,'shown','trial/2/reference','2031-07-23T16:41:41.221Z',20130000000,'{"showing":3,"complete":true}');
INSERT INTO "event" VALUES(11,1,'showing','trial/2/second','2031-07-23T16:41:45.247Z',22143000000,'{"showing":4,"presentation":1}');
INSERT INTO "event" VALUES(12,1,'shown','trial/2/second','2031-07-23T16:41:47.260Z',24156000000,'{"showing":4,"complete":true}');
INSERT INTO "event" VALUES(13,1,'answer','trial/2/dcr/impairment','2031-07-23T16:41:51.286Z',26169000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(14,1,'showing','trial/3/reference','2031-07-23T16:41:55.312Z',28182000000,'{"showing":5,"presentation":1}');
INSERT INTO "event" VALUES(15,1,'shown','trial/3/reference','2031-07-23T16:41:57.325Z',30195000000,'{"showing":5,"complete":true}');
INSERT INTO "event" VALUES(16,1,'showing','trial/3/second','2031-07-23T16:42:01.351Z',32208000000,'{"showing":6,"presentation":1}');
INSERT INTO "event" VALUES(17,1,'shown','trial/3/second','2031-07-23T16:42:03.364Z',34221000000,'{"showing":6,"complete":true}');
INSERT INTO "event" VALUES(18,1,'answer','trial/3/dcr/impairment','2031-07-23T16:42:07.390Z',36234000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(19,1,'showing','trial/4/reference','2031-07-23T16:42:11.416Z',38247000000,'{"showing":7,"presentation":1}');
INSERT INTO "event" VALUES(20,1,'shown','trial/4/reference','2031-07-23T16:42:13.429Z',40260000000,'{"showing":7,"complete":true}');
INSERT INTO "event" VALUES(21,1,'showing','trial/4/second','2031-07-23T16:42:17.455Z',42273000000,'{"showing":8,"presentation":1}');
INSERT INTO "event" VALUES(22,1,'shown','trial/4/second','2031-07-23T16:42:19.468Z',44286000000,'{"showing":8,"complete":true}');
INSERT INTO "event" VALUES(23,1,'answer','trial/4/dcr/impairment','2031-07-23T16:42:23.494Z',46299000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(24,1,'showing','trial/5/reference','2031-07-23T16:42:27.520Z',48312000000,'{"showing":9,"presentation":1}');
INSERT INTO "event" VALUES(25,1,'shown','trial/5/reference','2031-07-23T16:42:29.533Z',50325000000,'{"showing":9,"complete":true}');
INSERT INTO "event" VALUES(26,1,'showing','trial/5/second','2031-07-23T16:42:33.559Z',52338000000,'{"showing":10,"presentation":1}');
INSERT INTO "event" VALUES(27,1,'shown','trial/5/second','2031-07-23T16:42:35.572Z',54351000000,'{"showing":10,"complete":true}');
INSERT INTO "event" VALUES(28,1,'answer','trial/5/dcr/impairment','2031-07-23T16:42:39.598Z',56364000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(29,1,'answer','after/ipq/being_there','2031-07-23T16:42:43.624Z',58377000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(30,1,'answer','after/ipq/surrounded','2031-07-23T16:42:47.650Z',60390000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(31,1,'answer','after/ipq/pictures','2031-07-23T16:42:51.676Z',62403000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(32,1,'answer','after/ipq/not_present','2031-07-23T16:42:55.702Z',64416000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(33,1,'answer','after/ipq/acting','2031-07-23T16:42:59.728Z',66429000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(34,1,'answer','after/ipq/present','2031-07-23T16:43:03.754Z',68442000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(35,1,'answer','after/ipq/aware','2031-07-23T16:43:07.780Z',70455000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(36,1,'answer','after/ipq/unaware','2031-07-23T16:43:11.806Z',72468000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(37,1,'answer','after/ipq/attention','2031-07-23T16:43:15.832Z',74481000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(38,1,'answer','after/ipq/captivated','2031-07-23T16:43:19.858Z',76494000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(39,1,'answer','after/ipq/real','2031-07-23T16:43:23.884Z',78507000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(40,1,'answer','after/ipq/consistent','2031-07-23T16:43:27.910Z',80520000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(41,1,'answer','after/ipq/imagined','2031-07-23T16:43:31.936Z',82533000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(42,1,'answer','after/ipq/more_real','2031-07-23T16:43:35.962Z',84546000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(43,1,'answer','after/ssq/general_discomfort','2031-07-23T16:43:39.988Z',86559000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(44,1,'answer','after/ssq/fatigue','2031-07-23T16:43:44.014Z',88572000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(45,1,'answer','after/ssq/headache','2031-07-23T16:43:48.040Z',90585000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(46,1,'answer','after/ssq/eyestrain','2031-07-23T16:43:52.066Z',92598000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(47,1,'answer','after/ssq/difficulty_focusing','2031-07-23T16:43:56.092Z',94611000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(48,1,'answer','after/ssq/increased_salivation','2031-07-23T16:44:00.118Z',96624000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(49,1,'answer','after/ssq/sweating','2031-07-23T16:44:04.144Z',98637000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(50,1,'answer','after/ssq/nausea','2031-07-23T16:44:08.170Z',100650000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(51,1,'answer','after/ssq/difficulty_concentrating','2031-07-23T16:44:12.196Z',102663000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(52,1,'answer','after/ssq/fullness_of_head','2031-07-23T16:44:16.222Z',104676000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(53,1,'answer','after/ssq/blurred_vision','2031-07-23T16:44:20.248Z',106689000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(54,1,'answer','after/ssq/dizzy_eyes_open','2031-07-23T16:44:24.274Z',108702000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(55,1,'answer','after/ssq/dizzy_eyes_closed','2031-07-23T16:44:28.300Z',110715000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(56,1,'answer','after/ssq/vertigo','2031-07-23T16:44:32.326Z',112728000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(57,1,'answer','after/ssq/stomach_awareness','2031-07-23T16:44:36.352Z',114741000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(58,1,'answer','after/ssq/burping','2031-07-23T16:44:40.378Z',116754000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(59,1,'remark','trial/1','2031-07-23T16:44:42.391Z',118767000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(60,1,'end','','2031-07-23T16:44:44.404Z',120780000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(61,2,'begin','','2031-07-23T16:44:50.443Z',122793000000,'{"part":"main","row":916,"plan_text_changed":false}');
INSERT INTO "event" VALUES(62,2,'finished','instructions','2031-07-23T16:44:52.456Z',124806000000,'{}');
INSERT INTO "event" VALUES(63,2,'showing','trial/1/reference','2031-07-23T16:44:56.482Z',126819000000,'{"showing":11,"presentation":1}');
INSERT INTO "event" VALUES(64,2,'shown','trial/1/reference','2031-07-23T16:44:58.495Z',128832000000,'{"showing":11,"complete":true}');
INSERT INTO "event" VALUES(65,2,'showing','trial/1/second','2031-07-23T16:45:02.521Z',130845000000,'{"showing":12,"presentation":1}');
INSERT INTO "event" VALUES(66,2,'shown','trial/1/second','2031-07-23T16:45:04.534Z',132858000000,'{"showing":12,"complete":true}');
INSERT INTO "event" VALUES(67,2,'answer','trial/1/dcr/impairment','2031-07-23T16:45:08.560Z',134871000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(68,2,'answer','trial/1/dcr/impairment','2031-07-23T16:45:12.586Z',136884000000,'{"value":3.0,"revision":2}');
INSERT INTO "event" VALUES(69,2,'showing','trial/2/reference','2031-07-23T16:45:16.612Z',138897000000,'{"showing":13,"presentation":1}');
INSERT INTO "event" VALUES(70,2,'shown','trial/2/reference','2031-07-23T16:45:18.625Z',140910000000,'{"showing":13,"complete":true}');
INSERT INTO "event" VALUES(71,2,'showing','trial/2/second','2031-07-23T16:45:22.651Z',142923000000,'{"showing":14,"presentation":1}');
INSERT INTO "event" VALUES(72,2,'shown','trial/2/second','2031-07-23T16:45:24.664Z',144936000000,'{"showing":14,"complete":true}');
INSERT INTO "event" VALUES(73,2,'answer','trial/2/dcr/impairment','2031-07-23T16:45:28.690Z',146949000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(74,2,'showing','trial/3/reference','2031-07-23T16:45:32.716Z',148962000000,'{"showing":15,"presentation":1}');
INSERT INTO "event" VALUES(75,2,'shown','trial/3/reference','2031-07-23T16:45:34.729Z',150975000000,'{"showing":15,"complete":true}');
INSERT INTO "event" VALUES(76,2,'showing','trial/3/second','2031-07-23T16:45:38.755Z',152988000000,'{"showing":16,"presentation":1}');
INSERT INTO "event" VALUES(77,2,'shown','trial/3/second','2031-07-23T16:45:40.768Z',155001000000,'{"showing":16,"complete":true}');
INSERT INTO "event" VALUES(78,2,'answer','trial/3/dcr/impairment','2031-07-23T16:45:44.794Z',157014000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(79,2,'showing','trial/4/reference','2031-07-23T16:45:48.820Z',159027000000,'{"showing":17,"presentation":1}');
INSERT INTO "event" VALUES(80,2,'shown','trial/4/reference','2031-07-23T16:45:50.833Z',161040000000,'{"showing":17,"complete":true}');
INSERT INTO "event" VALUES(81,2,'showing','trial/4/second','2031-07-23T16:45:54.859Z',163053000000,'{"showing":18,"presentation":1}');
INSERT INTO "event" VALUES(82,2,'shown','trial/4/second','2031-07-23T16:45:56.872Z',165066000000,'{"showing":18,"complete":true}');
INSERT INTO "event" VALUES(83,2,'answer','trial/4/dcr/impairment','2031-07-23T16:46:00.898Z',167079000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(84,2,'showing','trial/5/reference','2031-07-23T16:46:04.924Z',169092000000,'{"showing":19,"presentation":1}');
INSERT INTO "event" VALUES(85,2,'shown','trial/5/reference','2031-07-23T16:46:06.937Z',171105000000,'{"showing":19,"complete":true}');
INSERT INTO "event" VALUES(86,2,'showing','trial/5/second','2031-07-23T16:46:10.963Z',173118000000,'{"showing":20,"presentation":1}');
INSERT INTO "event" VALUES(87,2,'shown','trial/5/second','2031-07-23T16:46:12.976Z',175131000000,'{"showing":20,"complete":true}');
INSERT INTO "event" VALUES(88,2,'answer','trial/5/dcr/impairment','2031-07-23T16:46:17.002Z',177144000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(89,2,'answer','after/ipq/being_there','2031-07-23T16:46:21.028Z',179157000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(90,2,'answer','after/ipq/surrounded','2031-07-23T16:46:25.054Z',181170000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(91,2,'answer','after/ipq/pictures','2031-07-23T16:46:29.080Z',183183000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(92,2,'answer','after/ipq/not_present','2031-07-23T16:46:33.106Z',185196000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(93,2,'answer','after/ipq/acting','2031-07-23T16:46:37.132Z',187209000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(94,2,'answer','after/ipq/present','2031-07-23T16:46:41.158Z',189222000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(95,2,'answer','after/ipq/aware','2031-07-23T16:46:45.184Z',191235000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(96,2,'answer','after/ipq/unaware','2031-07-23T16:46:49.210Z',193248000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(97,2,'answer','after/ipq/attention','2031-07-23T16:46:53.236Z',195261000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(98,2,'answer','after/ipq/captivated','2031-07-23T16:46:57.262Z',197274000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(99,2,'answer','after/ipq/real','2031-07-23T16:47:01.288Z',199287000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(100,2,'answer','after/ipq/consistent','2031-07-23T16:47:05.314Z',201300000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(101,2,'answer','after/ipq/imagined','2031-07-23T16:47:09.340Z',203313000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(102,2,'answer','after/ipq/more_real','2031-07-23T16:47:13.366Z',205326000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(103,2,'answer','after/ssq/general_discomfort','2031-07-23T16:47:17.392Z',207339000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(104,2,'answer','after/ssq/fatigue','2031-07-23T16:47:21.418Z',209352000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(105,2,'answer','after/ssq/headache','2031-07-23T16:47:25.444Z',211365000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(106,2,'answer','after/ssq/eyestrain','2031-07-23T16:47:29.470Z',213378000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(107,2,'answer','after/ssq/difficulty_focusing','2031-07-23T16:47:33.496Z',215391000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(108,2,'answer','after/ssq/increased_salivation','2031-07-23T16:47:37.522Z',217404000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(109,2,'answer','after/ssq/sweating','2031-07-23T16:47:41.548Z',219417000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(110,2,'answer','after/ssq/nausea','2031-07-23T16:47:45.574Z',221430000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(111,2,'answer','after/ssq/difficulty_concentrating','2031-07-23T16:47:49.600Z',223443000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(112,2,'answer','after/ssq/fullness_of_head','2031-07-23T16:47:53.626Z',225456000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(113,2,'answer','after/ssq/blurred_vision','2031-07-23T16:47:57.652Z',227469000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(114,2,'answer','after/ssq/dizzy_eyes_open','2031-07-23T16:48:01.678Z',229482000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(115,2,'answer','after/ssq/dizzy_eyes_closed','2031-07-23T16:48:05.704Z',231495000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(116,2,'answer','after/ssq/vertigo','2031-07-23T16:48:09.730Z',233508000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(117,2,'answer','after/ssq/stomach_awareness','2031-07-23T16:48:13.756Z',235521000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(118,2,'answer','after/ssq/burping','2031-07-23T16:48:17.782Z',237534000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(119,2,'remark','trial/1','2031-07-23T16:48:19.795Z',239547000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(120,2,'end','','2031-07-23T16:48:21.808Z',241560000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(121,3,'begin','','2031-07-23T16:48:27.847Z',243573000000,'{"part":"main","row":198,"plan_text_changed":false}');
INSERT INTO "event" VALUES(122,3,'finished','instructions','2031-07-23T16:48:29.860Z',245586000000,'{}');
INSERT INTO "event" VALUES(123,3,'showing','trial/1/reference','2031-07-23T16:48:33.886Z',247599000000,'{"showing":21,"presentation":1}');
INSERT INTO "event" VALUES(124,3,'shown','trial/1/reference','2031-07-23T16:48:35.899Z',249612000000,'{"showing":21,"complete":true}');
INSERT INTO "event" VALUES(125,3,'showing','trial/1/second','2031-07-23T16:48:39.925Z',251625000000,'{"showing":22,"presentation":1}');
INSERT INTO "event" VALUES(126,3,'shown','trial/1/second','2031-07-23T16:48:41.938Z',253638000000,'{"showing":22,"complete":true}');
INSERT INTO "event" VALUES(127,3,'answer','trial/1/dcr/impairment','2031-07-23T16:48:45.964Z',255651000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(128,3,'answer','trial/1/dcr/impairment','2031-07-23T16:48:49.990Z',257664000000,'{"value":5.0,"revision":2}');
INSERT INTO "event" VALUES(129,3,'showing','trial/2/reference','2031-07-23T16:48:54.016Z',259677000000,'{"showing":23,"presentation":1}');
INSERT INTO "event" VALUES(130,3,'shown','trial/2/reference','2031-07-23T16:48:56.029Z',261690000000,'{"showing":23,"complete":true}');
INSERT INTO "event" VALUES(131,3,'showing','trial/2/second','2031-07-23T16:49:00.055Z',263703000000,'{"showing":24,"presentation":1}');
INSERT INTO "event" VALUES(132,3,'shown','trial/2/second','2031-07-23T16:49:02.068Z',265716000000,'{"showing":24,"complete":true}');
INSERT INTO "event" VALUES(133,3,'answer','trial/2/dcr/impairment','2031-07-23T16:49:06.094Z',267729000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(134,3,'showing','trial/3/reference','2031-07-23T16:49:10.120Z',269742000000,'{"showing":25,"presentation":1}');
INSERT INTO "event" VALUES(135,3,'shown','trial/3/reference','2031-07-23T16:49:12.133Z',271755000000,'{"showing":25,"complete":true}');
INSERT INTO "event" VALUES(136,3,'showing','trial/3/second','2031-07-23T16:49:16.159Z',273768000000,'{"showing":26,"presentation":1}');
INSERT INTO "event" VALUES(137,3,'shown','trial/3/second','2031-07-23T16:49:18.172Z',275781000000,'{"showing":26,"complete":true}');
INSERT INTO "event" VALUES(138,3,'answer','trial/3/dcr/impairment','2031-07-23T16:49:22.198Z',277794000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(139,3,'showing','trial/4/reference','2031-07-23T16:49:26.224Z',279807000000,'{"showing":27,"presentation":1}');
INSERT INTO "event" VALUES(140,3,'shown','trial/4/reference','2031-07-23T16:49:28.237Z',281820000000,'{"showing":27,"complete":true}');
INSERT INTO "event" VALUES(141,3,'showing','trial/4/second','2031-07-23T16:49:32.263Z',283833000000,'{"showing":28,"presentation":1}');
INSERT INTO "event" VALUES(142,3,'shown','trial/4/second','2031-07-23T16:49:34.276Z',285846000000,'{"showing":28,"complete":true}');
INSERT INTO "event" VALUES(143,3,'answer','trial/4/dcr/impairment','2031-07-23T16:49:38.302Z',287859000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(144,3,'showing','trial/5/reference','2031-07-23T16:49:42.328Z',289872000000,'{"showing":29,"presentation":1}');
INSERT INTO "event" VALUES(145,3,'shown','trial/5/reference','2031-07-23T16:49:44.341Z',291885000000,'{"showing":29,"complete":true}');
INSERT INTO "event" VALUES(146,3,'showing','trial/5/second','2031-07-23T16:49:48.367Z',293898000000,'{"showing":30,"presentation":1}');
INSERT INTO "event" VALUES(147,3,'shown','trial/5/second','2031-07-23T16:49:50.380Z',295911000000,'{"showing":30,"complete":true}');
INSERT INTO "event" VALUES(148,3,'answer','trial/5/dcr/impairment','2031-07-23T16:49:54.406Z',297924000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(149,3,'answer','after/ipq/being_there','2031-07-23T16:49:58.432Z',299937000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(150,3,'answer','after/ipq/surrounded','2031-07-23T16:50:02.458Z',301950000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(151,3,'answer','after/ipq/pictures','2031-07-23T16:50:06.484Z',303963000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(152,3,'answer','after/ipq/not_present','2031-07-23T16:50:10.510Z',305976000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(153,3,'answer','after/ipq/acting','2031-07-23T16:50:14.536Z',307989000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(154,3,'answer','after/ipq/present','2031-07-23T16:50:18.562Z',310002000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(155,3,'answer','after/ipq/aware','2031-07-23T16:50:22.588Z',312015000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(156,3,'answer','after/ipq/unaware','2031-07-23T16:50:26.614Z',314028000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(157,3,'answer','after/ipq/attention','2031-07-23T16:50:30.640Z',316041000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(158,3,'answer','after/ipq/captivated','2031-07-23T16:50:34.666Z',318054000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(159,3,'answer','after/ipq/real','2031-07-23T16:50:38.692Z',320067000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(160,3,'answer','after/ipq/consistent','2031-07-23T16:50:42.718Z',322080000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(161,3,'answer','after/ipq/imagined','2031-07-23T16:50:46.744Z',324093000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(162,3,'answer','after/ipq/more_real','2031-07-23T16:50:50.770Z',326106000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(163,3,'answer','after/ssq/general_discomfort','2031-07-23T16:50:54.796Z',328119000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(164,3,'answer','after/ssq/fatigue','2031-07-23T16:50:58.822Z',330132000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(165,3,'answer','after/ssq/headache','2031-07-23T16:51:02.848Z',332145000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(166,3,'answer','after/ssq/eyestrain','2031-07-23T16:51:06.874Z',334158000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(167,3,'answer','after/ssq/difficulty_focusing','2031-07-23T16:51:10.900Z',336171000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(168,3,'answer','after/ssq/increased_salivation','2031-07-23T16:51:14.926Z',338184000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(169,3,'answer','after/ssq/sweating','2031-07-23T16:51:18.952Z',340197000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(170,3,'answer','after/ssq/nausea','2031-07-23T16:51:22.978Z',342210000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(171,3,'answer','after/ssq/difficulty_concentrating','2031-07-23T16:51:27.004Z',344223000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(172,3,'answer','after/ssq/fullness_of_head','2031-07-23T16:51:31.030Z',346236000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(173,3,'answer','after/ssq/blurred_vision','2031-07-23T16:51:35.056Z',348249000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(174,3,'answer','after/ssq/dizzy_eyes_open','2031-07-23T16:51:39.082Z',350262000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(175,3,'answer','after/ssq/dizzy_eyes_closed','2031-07-23T16:51:43.108Z',352275000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(176,3,'answer','after/ssq/vertigo','2031-07-23T16:51:47.134Z',354288000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(177,3,'answer','after/ssq/stomach_awareness','2031-07-23T16:51:51.160Z',356301000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(178,3,'answer','after/ssq/burping','2031-07-23T16:51:55.186Z',358314000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(179,3,'remark','trial/1','2031-07-23T16:51:57.199Z',360327000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(180,3,'end','','2031-07-23T16:51:59.212Z',362340000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(181,4,'begin','','2031-07-23T16:52:05.251Z',364353000000,'{"part":"main","row":371,"plan_text_changed":false}');
INSERT INTO "event" VALUES(182,4,'finished','instructions','2031-07-23T16:52:07.264Z',366366000000,'{}');
INSERT INTO "event" VALUES(183,4,'showing','trial/1/reference','2031-07-23T16:52:11.290Z',368379000000,'{"showing":31,"presentation":1}');
INSERT INTO "event" VALUES(184,4,'shown','trial/1/reference','2031-07-23T16:52:13.303Z',370392000000,'{"showing":31,"complete":false}');
INSERT INTO "event" VALUES(185,4,'showing','trial/1/reference','2031-07-23T16:52:17.329Z',372405000000,'{"showing":32,"presentation":2}');
INSERT INTO "event" VALUES(186,4,'shown','trial/1/reference','2031-07-23T16:52:19.342Z',374418000000,'{"showing":32,"complete":true}');
INSERT INTO "event" VALUES(187,4,'showing','trial/1/second','2031-07-23T16:52:23.368Z',376431000000,'{"showing":33,"presentation":1}');
INSERT INTO "event" VALUES(188,4,'shown','trial/1/second','2031-07-23T16:52:25.381Z',378444000000,'{"showing":33,"complete":true}');
INSERT INTO "event" VALUES(189,4,'answer','trial/1/dcr/impairment','2031-07-23T16:52:29.407Z',380457000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(190,4,'answer','trial/1/dcr/impairment','2031-07-23T16:52:33.433Z',382470000000,'{"value":5.0,"revision":2}');
INSERT INTO "event" VALUES(191,4,'showing','trial/2/reference','2031-07-23T16:52:37.459Z',384483000000,'{"showing":34,"presentation":1}');
INSERT INTO "event" VALUES(192,4,'shown','trial/2/reference','2031-07-23T16:52:39.472Z',386496000000,'{"showing":34,"complete":true}');
INSERT INTO "event" VALUES(193,4,'showing','trial/2/second','2031-07-23T16:52:43.498Z',388509000000,'{"showing":35,"presentation":1}');
INSERT INTO "event" VALUES(194,4,'shown','trial/2/second','2031-07-23T16:52:45.511Z',390522000000,'{"showing":35,"complete":true}');
INSERT INTO "event" VALUES(195,4,'answer','trial/2/dcr/impairment','2031-07-23T16:52:49.537Z',392535000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(196,4,'showing','trial/3/reference','2031-07-23T16:52:53.563Z',394548000000,'{"showing":36,"presentation":1}');
INSERT INTO "event" VALUES(197,4,'shown','trial/3/reference','2031-07-23T16:52:55.576Z',396561000000,'{"showing":36,"complete":true}');
INSERT INTO "event" VALUES(198,4,'showing','trial/3/second','2031-07-23T16:52:59.602Z',398574000000,'{"showing":37,"presentation":1}');
INSERT INTO "event" VALUES(199,4,'shown','trial/3/second','2031-07-23T16:53:01.615Z',400587000000,'{"showing":37,"complete":true}');
INSERT INTO "event" VALUES(200,4,'answer','trial/3/dcr/impairment','2031-07-23T16:53:05.641Z',402600000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(201,4,'showing','trial/4/reference','2031-07-23T16:53:09.667Z',404613000000,'{"showing":38,"presentation":1}');
INSERT INTO "event" VALUES(202,4,'shown','trial/4/reference','2031-07-23T16:53:11.680Z',406626000000,'{"showing":38,"complete":true}');
INSERT INTO "event" VALUES(203,4,'showing','trial/4/second','2031-07-23T16:53:15.706Z',408639000000,'{"showing":39,"presentation":1}');
INSERT INTO "event" VALUES(204,4,'shown','trial/4/second','2031-07-23T16:53:17.719Z',410652000000,'{"showing":39,"complete":true}');
INSERT INTO "event" VALUES(205,4,'answer','trial/4/dcr/impairment','2031-07-23T16:53:21.745Z',412665000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(206,4,'showing','trial/5/reference','2031-07-23T16:53:25.771Z',414678000000,'{"showing":40,"presentation":1}');
INSERT INTO "event" VALUES(207,4,'shown','trial/5/reference','2031-07-23T16:53:27.784Z',416691000000,'{"showing":40,"complete":true}');
INSERT INTO "event" VALUES(208,4,'showing','trial/5/second','2031-07-23T16:53:31.810Z',418704000000,'{"showing":41,"presentation":1}');
INSERT INTO "event" VALUES(209,4,'shown','trial/5/second','2031-07-23T16:53:33.823Z',420717000000,'{"showing":41,"complete":true}');
INSERT INTO "event" VALUES(210,4,'answer','trial/5/dcr/impairment','2031-07-23T16:53:37.849Z',422730000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(211,4,'answer','after/ipq/being_there','2031-07-23T16:53:41.875Z',424743000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(212,4,'answer','after/ipq/surrounded','2031-07-23T16:53:45.901Z',426756000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(213,4,'answer','after/ipq/pictures','2031-07-23T16:53:49.927Z',428769000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(214,4,'answer','after/ipq/not_present','2031-07-23T16:53:53.953Z',430782000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(215,4,'answer','after/ipq/acting','2031-07-23T16:53:57.979Z',432795000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(216,4,'answer','after/ipq/present','2031-07-23T16:54:02.005Z',434808000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(217,4,'answer','after/ipq/aware','2031-07-23T16:54:06.031Z',436821000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(218,4,'answer','after/ipq/unaware','2031-07-23T16:54:10.057Z',438834000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(219,4,'answer','after/ipq/attention','2031-07-23T16:54:14.083Z',440847000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(220,4,'answer','after/ipq/captivated','2031-07-23T16:54:18.109Z',442860000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(221,4,'answer','after/ipq/real','2031-07-23T16:54:22.135Z',444873000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(222,4,'answer','after/ipq/consistent','2031-07-23T16:54:26.161Z',446886000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(223,4,'answer','after/ipq/imagined','2031-07-23T16:54:30.187Z',448899000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(224,4,'answer','after/ipq/more_real','2031-07-23T16:54:34.213Z',450912000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(225,4,'answer','after/ssq/general_discomfort','2031-07-23T16:54:38.239Z',452925000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(226,4,'answer','after/ssq/fatigue','2031-07-23T16:54:42.265Z',454938000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(227,4,'answer','after/ssq/headache','2031-07-23T16:54:46.291Z',456951000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(228,4,'answer','after/ssq/eyestrain','2031-07-23T16:54:50.317Z',458964000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(229,4,'answer','after/ssq/difficulty_focusing','2031-07-23T16:54:54.343Z',460977000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(230,4,'answer','after/ssq/increased_salivation','2031-07-23T16:54:58.369Z',462990000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(231,4,'answer','after/ssq/sweating','2031-07-23T16:55:02.395Z',465003000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(232,4,'answer','after/ssq/nausea','2031-07-23T16:55:06.421Z',467016000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(233,4,'answer','after/ssq/difficulty_concentrating','2031-07-23T16:55:10.447Z',469029000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(234,4,'answer','after/ssq/fullness_of_head','2031-07-23T16:55:14.473Z',471042000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(235,4,'answer','after/ssq/blurred_vision','2031-07-23T16:55:18.499Z',473055000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(236,4,'answer','after/ssq/dizzy_eyes_open','2031-07-23T16:55:22.525Z',475068000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(237,4,'answer','after/ssq/dizzy_eyes_closed','2031-07-23T16:55:26.551Z',477081000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(238,4,'answer','after/ssq/vertigo','2031-07-23T16:55:30.577Z',479094000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(239,4,'answer','after/ssq/stomach_awareness','2031-07-23T16:55:34.603Z',481107000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(240,4,'answer','after/ssq/burping','2031-07-23T16:55:38.629Z',483120000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(241,4,'remark','trial/1','2031-07-23T16:55:40.642Z',485133000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(242,4,'end','','2031-07-23T16:55:42.655Z',487146000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(243,5,'begin','','2031-07-23T16:55:48.694Z',489159000000,'{"part":"main","row":935,"plan_text_changed":false}');
INSERT INTO "event" VALUES(244,5,'finished','instructions','2031-07-23T16:55:50.707Z',491172000000,'{}');
INSERT INTO "event" VALUES(245,5,'showing','trial/1/reference','2031-07-23T16:55:54.733Z',493185000000,'{"showing":42,"presentation":1}');
INSERT INTO "event" VALUES(246,5,'shown','trial/1/reference','2031-07-23T16:55:56.746Z',495198000000,'{"showing":42,"complete":true}');
INSERT INTO "event" VALUES(247,5,'showing','trial/1/second','2031-07-23T16:56:00.772Z',497211000000,'{"showing":43,"presentation":1}');
INSERT INTO "event" VALUES(248,5,'shown','trial/1/second','2031-07-23T16:56:02.785Z',499224000000,'{"showing":43,"complete":true}');
INSERT INTO "event" VALUES(249,5,'answer','trial/1/dcr/impairment','2031-07-23T16:56:06.811Z',501237000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(250,5,'answer','trial/1/dcr/impairment','2031-07-23T16:56:10.837Z',503250000000,'{"value":4.0,"revision":2}');
INSERT INTO "event" VALUES(251,5,'showing','trial/2/reference','2031-07-23T16:56:14.863Z',505263000000,'{"showing":44,"presentation":1}');
INSERT INTO "event" VALUES(252,5,'shown','trial/2/reference','2031-07-23T16:56:16.876Z',507276000000,'{"showing":44,"complete":true}');
INSERT INTO "event" VALUES(253,5,'showing','trial/2/second','2031-07-23T16:56:20.902Z',509289000000,'{"showing":45,"presentation":1}');
INSERT INTO "event" VALUES(254,5,'shown','trial/2/second','2031-07-23T16:56:22.915Z',511302000000,'{"showing":45,"complete":true}');
INSERT INTO "event" VALUES(255,5,'answer','trial/2/dcr/impairment','2031-07-23T16:56:26.941Z',513315000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(256,5,'showing','trial/3/reference','2031-07-23T16:56:30.967Z',515328000000,'{"showing":46,"presentation":1}');
INSERT INTO "event" VALUES(257,5,'shown','trial/3/reference','2031-07-23T16:56:32.980Z',517341000000,'{"showing":46,"complete":true}');
INSERT INTO "event" VALUES(258,5,'showing','trial/3/second','2031-07-23T16:56:37.006Z',519354000000,'{"showing":47,"presentation":1}');
INSERT INTO "event" VALUES(259,5,'shown','trial/3/second','2031-07-23T16:56:39.019Z',521367000000,'{"showing":47,"complete":true}');
INSERT INTO "event" VALUES(260,5,'answer','trial/3/dcr/impairment','2031-07-23T16:56:43.045Z',523380000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(261,5,'showing','trial/4/reference','2031-07-23T16:56:47.071Z',525393000000,'{"showing":48,"presentation":1}');
INSERT INTO "event" VALUES(262,5,'shown','trial/4/reference','2031-07-23T16:56:49.084Z',527406000000,'{"showing":48,"complete":true}');
INSERT INTO "event" VALUES(263,5,'showing','trial/4/second','2031-07-23T16:56:53.110Z',529419000000,'{"showing":49,"presentation":1}');
INSERT INTO "event" VALUES(264,5,'shown','trial/4/second','2031-07-23T16:56:55.123Z',531432000000,'{"showing":49,"complete":true}');
INSERT INTO "event" VALUES(265,5,'answer','trial/4/dcr/impairment','2031-07-23T16:56:59.149Z',533445000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(266,5,'showing','trial/5/reference','2031-07-23T16:57:03.175Z',535458000000,'{"showing":50,"presentation":1}');
INSERT INTO "event" VALUES(267,5,'shown','trial/5/reference','2031-07-23T16:57:05.188Z',537471000000,'{"showing":50,"complete":true}');
INSERT INTO "event" VALUES(268,5,'showing','trial/5/second','2031-07-23T16:57:09.214Z',539484000000,'{"showing":51,"presentation":1}');
INSERT INTO "event" VALUES(269,5,'shown','trial/5/second','2031-07-23T16:57:11.227Z',541497000000,'{"showing":51,"complete":true}');
INSERT INTO "event" VALUES(270,5,'answer','trial/5/dcr/impairment','2031-07-23T16:57:15.253Z',543510000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(271,5,'answer','after/ipq/being_there','2031-07-23T16:57:19.279Z',545523000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(272,5,'answer','after/ipq/surrounded','2031-07-23T16:57:23.305Z',547536000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(273,5,'answer','after/ipq/pictures','2031-07-23T16:57:27.331Z',549549000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(274,5,'answer','after/ipq/not_present','2031-07-23T16:57:31.357Z',551562000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(275,5,'answer','after/ipq/acting','2031-07-23T16:57:35.383Z',553575000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(276,5,'answer','after/ipq/present','2031-07-23T16:57:39.409Z',555588000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(277,5,'answer','after/ipq/aware','2031-07-23T16:57:43.435Z',557601000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(278,5,'answer','after/ipq/unaware','2031-07-23T16:57:47.461Z',559614000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(279,5,'answer','after/ipq/attention','2031-07-23T16:57:51.487Z',561627000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(280,5,'answer','after/ipq/captivated','2031-07-23T16:57:55.513Z',563640000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(281,5,'answer','after/ipq/real','2031-07-23T16:57:59.539Z',565653000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(282,5,'answer','after/ipq/consistent','2031-07-23T16:58:03.565Z',567666000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(283,5,'answer','after/ipq/imagined','2031-07-23T16:58:07.591Z',569679000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(284,5,'answer','after/ipq/more_real','2031-07-23T16:58:11.617Z',571692000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(285,5,'answer','after/ssq/general_discomfort','2031-07-23T16:58:15.643Z',573705000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(286,5,'answer','after/ssq/fatigue','2031-07-23T16:58:19.669Z',575718000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(287,5,'answer','after/ssq/headache','2031-07-23T16:58:23.695Z',577731000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(288,5,'answer','after/ssq/eyestrain','2031-07-23T16:58:27.721Z',579744000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(289,5,'answer','after/ssq/difficulty_focusing','2031-07-23T16:58:31.747Z',581757000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(290,5,'answer','after/ssq/increased_salivation','2031-07-23T16:58:35.773Z',583770000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(291,5,'answer','after/ssq/sweating','2031-07-23T16:58:39.799Z',585783000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(292,5,'answer','after/ssq/nausea','2031-07-23T16:58:43.825Z',587796000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(293,5,'answer','after/ssq/difficulty_concentrating','2031-07-23T16:58:47.851Z',589809000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(294,5,'answer','after/ssq/fullness_of_head','2031-07-23T16:58:51.877Z',591822000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(295,5,'answer','after/ssq/blurred_vision','2031-07-23T16:58:55.903Z',593835000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(296,5,'answer','after/ssq/dizzy_eyes_open','2031-07-23T16:58:59.929Z',595848000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(297,5,'answer','after/ssq/dizzy_eyes_closed','2031-07-23T16:59:03.955Z',597861000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(298,5,'answer','after/ssq/vertigo','2031-07-23T16:59:07.981Z',599874000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(299,5,'answer','after/ssq/stomach_awareness','2031-07-23T16:59:12.007Z',601887000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(300,5,'answer','after/ssq/burping','2031-07-23T16:59:16.033Z',603900000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(301,5,'remark','trial/1','2031-07-23T16:59:18.046Z',605913000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(302,5,'end','','2031-07-23T16:59:20.059Z',607926000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(303,6,'begin','','2031-07-23T16:59:26.098Z',609939000000,'{"part":"main","row":653,"plan_text_changed":false}');
INSERT INTO "event" VALUES(304,6,'finished','instructions','2031-07-23T16:59:28.111Z',611952000000,'{}');
INSERT INTO "event" VALUES(305,6,'showing','trial/1/reference','2031-07-23T16:59:32.137Z',613965000000,'{"showing":52,"presentation":1}');
INSERT INTO "event" VALUES(306,6,'shown','trial/1/reference','2031-07-23T16:59:34.150Z',615978000000,'{"showing":52,"complete":true}');
INSERT INTO "event" VALUES(307,6,'showing','trial/1/second','2031-07-23T16:59:38.176Z',617991000000,'{"showing":53,"presentation":1}');
INSERT INTO "event" VALUES(308,6,'shown','trial/1/second','2031-07-23T16:59:40.189Z',620004000000,'{"showing":53,"complete":true}');
INSERT INTO "event" VALUES(309,6,'answer','trial/1/dcr/impairment','2031-07-23T16:59:44.215Z',622017000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(310,6,'answer','trial/1/dcr/impairment','2031-07-23T16:59:48.241Z',624030000000,'{"value":3.0,"revision":2}');
INSERT INTO "event" VALUES(311,6,'showing','trial/2/reference','2031-07-23T16:59:52.267Z',626043000000,'{"showing":54,"presentation":1}');
INSERT INTO "event" VALUES(312,6,'shown','trial/2/reference','2031-07-23T16:59:54.280Z',628056000000,'{"showing":54,"complete":true}');
INSERT INTO "event" VALUES(313,6,'showing','trial/2/second','2031-07-23T16:59:58.306Z',630069000000,'{"showing":55,"presentation":1}');
INSERT INTO "event" VALUES(314,6,'shown','trial/2/second','2031-07-23T17:00:00.319Z',632082000000,'{"showing":55,"complete":true}');
INSERT INTO "event" VALUES(315,6,'answer','trial/2/dcr/impairment','2031-07-23T17:00:04.345Z',634095000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(316,6,'showing','trial/3/reference','2031-07-23T17:00:08.371Z',636108000000,'{"showing":56,"presentation":1}');
INSERT INTO "event" VALUES(317,6,'shown','trial/3/reference','2031-07-23T17:00:10.384Z',638121000000,'{"showing":56,"complete":true}');
INSERT INTO "event" VALUES(318,6,'showing','trial/3/second','2031-07-23T17:00:14.410Z',640134000000,'{"showing":57,"presentation":1}');
INSERT INTO "event" VALUES(319,6,'shown','trial/3/second','2031-07-23T17:00:16.423Z',642147000000,'{"showing":57,"complete":true}');
INSERT INTO "event" VALUES(320,6,'answer','trial/3/dcr/impairment','2031-07-23T17:00:20.449Z',644160000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(321,6,'remark','trial/1','2031-07-23T17:00:22.462Z',646173000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(322,6,'end','','2031-07-23T17:00:24.475Z',648186000000,'{"status":"stopped","why":"asked for"}');
CREATE TABLE participant (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE COLLATE NOCASE,
  sub TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('person', 'pilot', 'simulated')),
  withdrawing INTEGER NOT NULL DEFAULT 0
) STRICT;
INSERT INTO "participant" VALUES(1,'P0','3yntyo5zgehx','person',0);
INSERT INTO "participant" VALUES(2,'P1','6102emt41h9k','person',0);
INSERT INTO "participant" VALUES(3,'P2','xklju5vq8aka','person',0);
INSERT INTO "participant" VALUES(4,'P3','th8h547e7p0s','person',0);
INSERT INTO "participant" VALUES(5,'P4','woladu83t622','person',0);
INSERT INTO "participant" VALUES(6,'stop','zjqxvi1fjlsx','person',0);
CREATE TABLE plan (id INTEGER PRIMARY KEY, text TEXT NOT NULL, meaning TEXT NOT NULL, UNIQUE (text, meaning)) STRICT;
INSERT INTO "plan" VALUES(1,'schema = 1
name = "dcr"
title = "Beside the reference"
blind = "participant"
[common]
scene = "planes"
size = "48x40"
lens = "none"
[trial]
seconds = "until done"
longest = 30
shows = "reference first"
order = "random"
scales = ["dcr"]
[instructions]
text = "Look at both."
[ready]
title = "Begin"
text = "Now."
[thanks]
text = "Bye."
[questionnaires]
after = ["ipq", "ssq"]
[[condition]]
name = "f"
latency = [100, 300]
warp = ["none", "rotation"]
[[condition]]
name = "ref"
latency = 0
warp = "none"
reference = true
','{"conditions":[{"name":"f-latency100-none","settings":{"latency":100,"lens":"none","scene":"planes","size":"48x40","warp":"none"},"reference":false},{"name":"f-latency100-rotation","settings":{"latency":100,"lens":"none","scene":"planes","size":"48x40","warp":"rotation"},"reference":false},{"name":"f-latency300-none","settings":{"latency":300,"lens":"none","scene":"planes","size":"48x40","warp":"none"},"reference":false},{"name":"f-latency300-rotation","settings":{"latency":300,"lens":"none","scene":"planes","size":"48x40","warp":"rotation"},"reference":false},{"name":"ref","settings":{"latency":0,"lens":"none","scene":"planes","size":"48x40","warp":"none"},"reference":true}],"seconds":["until done",30.0],"repeats":1,"order":"random","seed":0,"scales":[{"name":"dcr","asked":["",["impairment","How much was the second impaired, compared with the reference before it?"]],"range":[1.0,5.0,1.0],"anchors":{"1":"very annoying","2":"annoying","3":"slightly annoying","4":"perceptible but not annoying","5":"imperceptible"},"low_is_good":false}],"practice":null,"sickness":null,"before":[],"after":[{"name":"ipq","asked":["",["being_there","In the computer generated world I had a sense of \"being there\".",{"0":"not at all","6":"very much"}],["surrounded","Somehow I felt that the virtual world surrounded me."],["pictures","I felt like I was just perceiving pictures."],["not_present","I did not feel present in the virtual space.",{"0":"did not feel present","6":"felt present"}],["acting","I had a sense of acting in the virtual space, rather than operating something from outside."],["present","I felt present in the virtual space."],["aware","How aware were you of the real world surrounding while navigating in the virtual world (sounds, room temperature, other people, and so on)?",{"0":"extremely aware","3":"moderately aware","6":"not aware at all"}],["unaware","I was not aware of my real environment."],["attention","I still paid attention to the real environment."],["captivated","I was completely captivated by the virtual world."],["real","How real did the virtual world seem to you?",{"0":"completely real","6":"not real at all"}],["consistent","How much did your experience in the virtual environment seem consistent with your real world experience?",{"0":"not consistent","3":"moderately consistent","6":"very consistent"}],["imagined","How real did the virtual world seem to you?",{"0":"about as real as an imagined world","6":"indistinguishable from the real world"}],["more_real","The virtual world seemed more realistic than the real world."]],"range":[0.0,6.0,1.0],"anchors":{"0":"fully disagree","6":"fully agree"},"low_is_good":false},{"name":"ssq","asked":["How much does this affect you right now?",["general_discomfort","General discomfort"],["fatigue","Fatigue"],["headache","Headache"],["eyestrain","Eyestrain"],["difficulty_focusing","Difficulty focusing"],["increased_salivation","Increased salivation"],["sweating","Sweating"],["nausea","Nausea"],["difficulty_concentrating","Difficulty concentrating"],["fullness_of_head","Fullness of head"],["blurred_vision","Blurred vision"],["dizzy_eyes_open","Dizzy (eyes open)"],["dizzy_eyes_closed","Dizzy (eyes closed)"],["vertigo","Vertigo"],["stomach_awareness","Stomach awareness"],["burping","Burping"]],"range":[0.0,3.0,1.0],"anchors":{"0":"none","1":"slight","2":"moderate","3":"severe"},"low_is_good":true}],"shows":"reference first"}');
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
INSERT INTO "session" VALUES(1,1,1,'main',712,'[["f-latency100-rotation","f-latency300-rotation","f-latency100-none","f-latency300-none","ref"]]',1,'complete','','2031-07-23T16:41:11.026Z','2031-07-23T16:44:46.417Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(2,2,1,'main',916,'[["ref","f-latency300-none","f-latency300-rotation","f-latency100-rotation","f-latency100-none"]]',1,'complete','','2031-07-23T16:44:48.430Z','2031-07-23T16:48:23.821Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(3,3,1,'main',198,'[["f-latency300-rotation","f-latency100-none","f-latency300-none","ref","f-latency100-rotation"]]',1,'complete','','2031-07-23T16:48:25.834Z','2031-07-23T16:52:01.225Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-P2.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(4,4,1,'main',371,'[["f-latency300-rotation","ref","f-latency100-none","f-latency300-none","f-latency100-rotation"]]',1,'complete','','2031-07-23T16:52:03.238Z','2031-07-23T16:55:44.668Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(5,5,1,'main',935,'[["f-latency100-rotation","f-latency300-rotation","f-latency100-none","f-latency300-none","ref"]]',1,'complete','','2031-07-23T16:55:46.681Z','2031-07-23T16:59:22.072Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(6,6,1,'main',653,'[["f-latency300-rotation","f-latency300-none","ref","f-latency100-rotation","f-latency100-none"]]',1,'stopped','asked for','2031-07-23T16:59:24.085Z','2031-07-23T17:00:26.488Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
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
INSERT INTO "showing" VALUES(1,1,'trial/1/reference',1,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','3yntyo5zgehx_ses-1_trial-1-reference_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:17.065Z');
INSERT INTO "showing" VALUES(2,1,'trial/1/second',1,1,'f-latency100-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"rotation"}','3yntyo5zgehx_ses-1_trial-1-second_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:23.104Z');
INSERT INTO "showing" VALUES(3,1,'trial/2/reference',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','3yntyo5zgehx_ses-1_trial-2-reference_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:37.195Z');
INSERT INTO "showing" VALUES(4,1,'trial/2/second',2,1,'f-latency300-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"rotation"}','3yntyo5zgehx_ses-1_trial-2-second_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:43.234Z');
INSERT INTO "showing" VALUES(5,1,'trial/3/reference',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','3yntyo5zgehx_ses-1_trial-3-reference_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:53.299Z');
INSERT INTO "showing" VALUES(6,1,'trial/3/second',3,1,'f-latency100-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"none"}','3yntyo5zgehx_ses-1_trial-3-second_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:59.338Z');
INSERT INTO "showing" VALUES(7,1,'trial/4/reference',4,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','3yntyo5zgehx_ses-1_trial-4-reference_1.csv','{"latency_ms_median":429.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":26.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:09.403Z');
INSERT INTO "showing" VALUES(8,1,'trial/4/second',4,1,'f-latency300-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"none"}','3yntyo5zgehx_ses-1_trial-4-second_1.csv','{"latency_ms_median":429.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":26.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:15.442Z');
INSERT INTO "showing" VALUES(9,1,'trial/5/reference',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','3yntyo5zgehx_ses-1_trial-5-reference_1.csv','{"latency_ms_median":436.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":25.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:25.507Z');
INSERT INTO "showing" VALUES(10,1,'trial/5/second',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','3yntyo5zgehx_ses-1_trial-5-second_1.csv','{"latency_ms_median":436.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":25.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:31.546Z');
INSERT INTO "showing" VALUES(11,2,'trial/1/reference',1,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','6102emt41h9k_ses-1_trial-1-reference_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:44:54.469Z');
INSERT INTO "showing" VALUES(12,2,'trial/1/second',1,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','6102emt41h9k_ses-1_trial-1-second_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:00.508Z');
INSERT INTO "showing" VALUES(13,2,'trial/2/reference',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','6102emt41h9k_ses-1_trial-2-reference_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:14.599Z');
INSERT INTO "showing" VALUES(14,2,'trial/2/second',2,1,'f-latency300-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"none"}','6102emt41h9k_ses-1_trial-2-second_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:20.638Z');
INSERT INTO "showing" VALUES(15,2,'trial/3/reference',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','6102emt41h9k_ses-1_trial-3-reference_1.csv','{"latency_ms_median":423.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:30.703Z');
INSERT INTO "showing" VALUES(16,2,'trial/3/second',3,1,'f-latency300-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"rotation"}','6102emt41h9k_ses-1_trial-3-second_1.csv','{"latency_ms_median":423.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:36.742Z');
INSERT INTO "showing" VALUES(17,2,'trial/4/reference',4,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','6102emt41h9k_ses-1_trial-4-reference_1.csv','{"latency_ms_median":430.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:46.807Z');
INSERT INTO "showing" VALUES(18,2,'trial/4/second',4,1,'f-latency100-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"rotation"}','6102emt41h9k_ses-1_trial-4-second_1.csv','{"latency_ms_median":430.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:52.846Z');
INSERT INTO "showing" VALUES(19,2,'trial/5/reference',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','6102emt41h9k_ses-1_trial-5-reference_1.csv','{"latency_ms_median":437.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:02.911Z');
INSERT INTO "showing" VALUES(20,2,'trial/5/second',5,1,'f-latency100-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"none"}','6102emt41h9k_ses-1_trial-5-second_1.csv','{"latency_ms_median":437.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:08.950Z');
INSERT INTO "showing" VALUES(21,3,'trial/1/reference',1,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','xklju5vq8aka_ses-1_trial-1-reference_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:31.873Z');
INSERT INTO "showing" VALUES(22,3,'trial/1/second',1,1,'f-latency300-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"rotation"}','xklju5vq8aka_ses-1_trial-1-second_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:37.912Z');
INSERT INTO "showing" VALUES(23,3,'trial/2/reference',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','xklju5vq8aka_ses-1_trial-2-reference_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:52.003Z');
INSERT INTO "showing" VALUES(24,3,'trial/2/second',2,1,'f-latency100-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"none"}','xklju5vq8aka_ses-1_trial-2-second_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:58.042Z');
INSERT INTO "showing" VALUES(25,3,'trial/3/reference',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','xklju5vq8aka_ses-1_trial-3-reference_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:08.107Z');
INSERT INTO "showing" VALUES(26,3,'trial/3/second',3,1,'f-latency300-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"none"}','xklju5vq8aka_ses-1_trial-3-second_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:14.146Z');
INSERT INTO "showing" VALUES(27,3,'trial/4/reference',4,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','xklju5vq8aka_ses-1_trial-4-reference_1.csv','{"latency_ms_median":431.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:24.211Z');
INSERT INTO "showing" VALUES(28,3,'trial/4/second',4,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','xklju5vq8aka_ses-1_trial-4-second_1.csv','{"latency_ms_median":431.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:30.250Z');
INSERT INTO "showing" VALUES(29,3,'trial/5/reference',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','xklju5vq8aka_ses-1_trial-5-reference_1.csv','{"latency_ms_median":438.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:40.315Z');
INSERT INTO "showing" VALUES(30,3,'trial/5/second',5,1,'f-latency100-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"rotation"}','xklju5vq8aka_ses-1_trial-5-second_1.csv','{"latency_ms_median":438.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:46.354Z');
INSERT INTO "showing" VALUES(31,4,'trial/1/reference',1,1,'ref',1,0,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-1-reference_1.csv','{}','{}','2031-07-23T16:52:09.277Z');
INSERT INTO "showing" VALUES(32,4,'trial/1/reference',1,1,'ref',2,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-1-reference_2.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:15.316Z');
INSERT INTO "showing" VALUES(33,4,'trial/1/second',1,1,'f-latency300-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"rotation"}','th8h547e7p0s_ses-1_trial-1-second_1.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:21.355Z');
INSERT INTO "showing" VALUES(34,4,'trial/2/reference',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-2-reference_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:35.446Z');
INSERT INTO "showing" VALUES(35,4,'trial/2/second',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-2-second_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:41.485Z');
INSERT INTO "showing" VALUES(36,4,'trial/3/reference',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-3-reference_1.csv','{"latency_ms_median":425.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:51.550Z');
INSERT INTO "showing" VALUES(37,4,'trial/3/second',3,1,'f-latency100-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"none"}','th8h547e7p0s_ses-1_trial-3-second_1.csv','{"latency_ms_median":425.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:57.589Z');
INSERT INTO "showing" VALUES(38,4,'trial/4/reference',4,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-4-reference_1.csv','{"latency_ms_median":432.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:07.654Z');
INSERT INTO "showing" VALUES(39,4,'trial/4/second',4,1,'f-latency300-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"none"}','th8h547e7p0s_ses-1_trial-4-second_1.csv','{"latency_ms_median":432.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:13.693Z');
INSERT INTO "showing" VALUES(40,4,'trial/5/reference',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','th8h547e7p0s_ses-1_trial-5-reference_1.csv','{"latency_ms_median":439.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:23.758Z');
INSERT INTO "showing" VALUES(41,4,'trial/5/second',5,1,'f-latency100-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"rotation"}','th8h547e7p0s_ses-1_trial-5-second_1.csv','{"latency_ms_median":439.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:29.797Z');
INSERT INTO "showing" VALUES(42,5,'trial/1/reference',1,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','woladu83t622_ses-1_trial-1-reference_1.csv','{"latency_ms_median":412.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120","onset_s":13.5}','{"psnr_db":28.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:52.720Z');
INSERT INTO "showing" VALUES(43,5,'trial/1/second',1,1,'f-latency100-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"rotation"}','woladu83t622_ses-1_trial-1-second_1.csv','{"latency_ms_median":412.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120","onset_s":13.5}','{"psnr_db":28.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:58.759Z');
INSERT INTO "showing" VALUES(44,5,'trial/2/reference',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','woladu83t622_ses-1_trial-2-reference_1.csv','{"latency_ms_median":419.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120","onset_s":14.5}','{"psnr_db":27.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:12.850Z');
INSERT INTO "showing" VALUES(45,5,'trial/2/second',2,1,'f-latency300-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"rotation"}','woladu83t622_ses-1_trial-2-second_1.csv','{"latency_ms_median":419.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120","onset_s":14.5}','{"psnr_db":27.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:18.889Z');
INSERT INTO "showing" VALUES(46,5,'trial/3/reference',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','woladu83t622_ses-1_trial-3-reference_1.csv','{"latency_ms_median":426.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120","onset_s":15.5}','{"psnr_db":26.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:28.954Z');
INSERT INTO "showing" VALUES(47,5,'trial/3/second',3,1,'f-latency100-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":100,"warp":"none"}','woladu83t622_ses-1_trial-3-second_1.csv','{"latency_ms_median":426.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120","onset_s":15.5}','{"psnr_db":26.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:34.993Z');
INSERT INTO "showing" VALUES(48,5,'trial/4/reference',4,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','woladu83t622_ses-1_trial-4-reference_1.csv','{"latency_ms_median":433.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120","onset_s":16.5}','{"psnr_db":25.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:45.058Z');
INSERT INTO "showing" VALUES(49,5,'trial/4/second',4,1,'f-latency300-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"none"}','woladu83t622_ses-1_trial-4-second_1.csv','{"latency_ms_median":433.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120","onset_s":16.5}','{"psnr_db":25.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:51.097Z');
INSERT INTO "showing" VALUES(50,5,'trial/5/reference',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','woladu83t622_ses-1_trial-5-reference_1.csv','{"latency_ms_median":440.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120","onset_s":17.5}','{"psnr_db":24.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:57:01.162Z');
INSERT INTO "showing" VALUES(51,5,'trial/5/second',5,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','woladu83t622_ses-1_trial-5-second_1.csv','{"latency_ms_median":440.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120","onset_s":17.5}','{"psnr_db":24.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:57:07.201Z');
INSERT INTO "showing" VALUES(52,6,'trial/1/reference',1,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','zjqxvi1fjlsx_ses-1_trial-1-reference_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:30.124Z');
INSERT INTO "showing" VALUES(53,6,'trial/1/second',1,1,'f-latency300-rotation',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"rotation"}','zjqxvi1fjlsx_ses-1_trial-1-second_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:36.163Z');
INSERT INTO "showing" VALUES(54,6,'trial/2/reference',2,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','zjqxvi1fjlsx_ses-1_trial-2-reference_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:50.254Z');
INSERT INTO "showing" VALUES(55,6,'trial/2/second',2,1,'f-latency300-none',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":300,"warp":"none"}','zjqxvi1fjlsx_ses-1_trial-2-second_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:56.293Z');
INSERT INTO "showing" VALUES(56,6,'trial/3/reference',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','zjqxvi1fjlsx_ses-1_trial-3-reference_1.csv','{"latency_ms_median":431.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.9,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:00:06.358Z');
INSERT INTO "showing" VALUES(57,6,'trial/3/second',3,1,'ref',1,1,'{"scene":"planes","size":"48x40","lens":"none","latency":0,"warp":"none"}','zjqxvi1fjlsx_ses-1_trial-3-second_1.csv','{"latency_ms_median":431.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.9,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:00:12.397Z');
CREATE TABLE study (name TEXT NOT NULL, made_by TEXT NOT NULL) STRICT;
INSERT INTO "study" VALUES('dcr','0.2.0');
CREATE TABLE withdrawn (code TEXT NOT NULL PRIMARY KEY COLLATE NOCASE, cleaned INTEGER NOT NULL) STRICT;
CREATE INDEX event_of_session ON event (session, kind);
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('participant',6);
INSERT INTO "sqlite_sequence" VALUES('session',6);
INSERT INTO "sqlite_sequence" VALUES('event',322);
INSERT INTO "sqlite_sequence" VALUES('showing',57);
INSERT INTO "sqlite_sequence" VALUES('answer',184);
COMMIT;
