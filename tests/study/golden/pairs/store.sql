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
INSERT INTO "answer" VALUES(1,1,'before/demographics/age',1,'before',0,'demographics','age',87.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:15.052Z',NULL);
INSERT INTO "answer" VALUES(2,1,'before/demographics/gender',1,'before',0,'demographics','gender',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:19.078Z',NULL);
INSERT INTO "answer" VALUES(3,1,'before/demographics/vision',1,'before',0,'demographics','vision',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:23.104Z',NULL);
INSERT INTO "answer" VALUES(4,1,'before/demographics/headsets',1,'before',0,'demographics','headsets',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:27.130Z',NULL);
INSERT INTO "answer" VALUES(5,1,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'experimenter','2031-07-23T16:41:43.234Z',2);
INSERT INTO "answer" VALUES(6,1,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:47.260Z',2);
INSERT INTO "answer" VALUES(7,1,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:51.286Z',2);
INSERT INTO "answer" VALUES(8,1,'trial/1/misc/misc',1,'trial',1,'misc','misc',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:55.312Z',2);
INSERT INTO "answer" VALUES(9,1,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:11.416Z',4);
INSERT INTO "answer" VALUES(10,1,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:15.442Z',4);
INSERT INTO "answer" VALUES(11,1,'trial/2/misc/misc',1,'trial',2,'misc','misc',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:19.468Z',4);
INSERT INTO "answer" VALUES(12,1,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:35.572Z',6);
INSERT INTO "answer" VALUES(13,1,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:39.598Z',6);
INSERT INTO "answer" VALUES(14,1,'trial/3/misc/misc',1,'trial',3,'misc','misc',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:43.624Z',6);
INSERT INTO "answer" VALUES(15,1,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:59.728Z',8);
INSERT INTO "answer" VALUES(16,1,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:03.754Z',8);
INSERT INTO "answer" VALUES(17,1,'trial/4/misc/misc',1,'trial',4,'misc','misc',4.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:07.780Z',8);
INSERT INTO "answer" VALUES(18,1,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:23.884Z',10);
INSERT INTO "answer" VALUES(19,1,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:27.910Z',10);
INSERT INTO "answer" VALUES(20,1,'trial/5/misc/misc',1,'trial',5,'misc','misc',5.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:31.936Z',10);
INSERT INTO "answer" VALUES(21,1,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:48.040Z',12);
INSERT INTO "answer" VALUES(22,1,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:52.066Z',12);
INSERT INTO "answer" VALUES(23,1,'trial/6/misc/misc',1,'trial',6,'misc','misc',6.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:56.092Z',12);
INSERT INTO "answer" VALUES(24,1,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',65.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:00.118Z',NULL);
INSERT INTO "answer" VALUES(25,1,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',55.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:04.144Z',NULL);
INSERT INTO "answer" VALUES(26,1,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',55.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:08.170Z',NULL);
INSERT INTO "answer" VALUES(27,1,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',95.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:12.196Z',NULL);
INSERT INTO "answer" VALUES(28,1,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',25.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:16.222Z',NULL);
INSERT INTO "answer" VALUES(29,1,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',85.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:44:20.248Z',NULL);
INSERT INTO "answer" VALUES(30,2,'before/demographics/age',1,'before',0,'demographics','age',55.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:34.339Z',NULL);
INSERT INTO "answer" VALUES(31,2,'before/demographics/gender',1,'before',0,'demographics','gender',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:38.365Z',NULL);
INSERT INTO "answer" VALUES(32,2,'before/demographics/vision',1,'before',0,'demographics','vision',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:42.391Z',NULL);
INSERT INTO "answer" VALUES(33,2,'before/demographics/headsets',1,'before',0,'demographics','headsets',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:46.417Z',NULL);
INSERT INTO "answer" VALUES(34,2,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'participant','2031-07-23T16:45:02.521Z',14);
INSERT INTO "answer" VALUES(35,2,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:06.547Z',14);
INSERT INTO "answer" VALUES(36,2,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:45:10.573Z',14);
INSERT INTO "answer" VALUES(37,2,'trial/1/misc/misc',1,'trial',1,'misc','misc',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:14.599Z',14);
INSERT INTO "answer" VALUES(38,2,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:45:30.703Z',16);
INSERT INTO "answer" VALUES(39,2,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:45:34.729Z',16);
INSERT INTO "answer" VALUES(40,2,'trial/2/misc/misc',1,'trial',2,'misc','misc',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:38.755Z',16);
INSERT INTO "answer" VALUES(41,2,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:54.859Z',18);
INSERT INTO "answer" VALUES(42,2,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:45:58.885Z',18);
INSERT INTO "answer" VALUES(43,2,'trial/3/misc/misc',1,'trial',3,'misc','misc',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:02.911Z',18);
INSERT INTO "answer" VALUES(44,2,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:19.015Z',20);
INSERT INTO "answer" VALUES(45,2,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:46:23.041Z',20);
INSERT INTO "answer" VALUES(46,2,'trial/4/misc/misc',1,'trial',4,'misc','misc',5.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:27.067Z',20);
INSERT INTO "answer" VALUES(47,2,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:43.171Z',22);
INSERT INTO "answer" VALUES(48,2,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:46:47.197Z',22);
INSERT INTO "answer" VALUES(49,2,'trial/5/misc/misc',1,'trial',5,'misc','misc',6.0,2.65000003300000042116e+00,'participant','2031-07-23T16:46:51.223Z',22);
INSERT INTO "answer" VALUES(50,2,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:07.327Z',24);
INSERT INTO "answer" VALUES(51,2,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:47:11.353Z',24);
INSERT INTO "answer" VALUES(52,2,'trial/6/misc/misc',1,'trial',6,'misc','misc',7.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:15.379Z',24);
INSERT INTO "answer" VALUES(53,2,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',65.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:19.405Z',NULL);
INSERT INTO "answer" VALUES(54,2,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',55.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:23.431Z',NULL);
INSERT INTO "answer" VALUES(55,2,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',5.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:27.457Z',NULL);
INSERT INTO "answer" VALUES(56,2,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:31.483Z',NULL);
INSERT INTO "answer" VALUES(57,2,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',90.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:35.509Z',NULL);
INSERT INTO "answer" VALUES(58,2,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',75.0,2.65000003300000042116e+00,'participant','2031-07-23T16:47:39.535Z',NULL);
INSERT INTO "answer" VALUES(59,3,'before/demographics/age',1,'before',0,'demographics','age',86.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:53.626Z',NULL);
INSERT INTO "answer" VALUES(60,3,'before/demographics/gender',1,'before',0,'demographics','gender',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:57.652Z',NULL);
INSERT INTO "answer" VALUES(61,3,'before/demographics/vision',1,'before',0,'demographics','vision',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:01.678Z',NULL);
INSERT INTO "answer" VALUES(62,3,'before/demographics/headsets',1,'before',0,'demographics','headsets',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:05.704Z',NULL);
INSERT INTO "answer" VALUES(63,3,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'participant','2031-07-23T16:48:21.808Z',26);
INSERT INTO "answer" VALUES(64,3,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:25.834Z',26);
INSERT INTO "answer" VALUES(65,3,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,3.65000003300000042116e+00,'participant','2031-07-23T16:48:29.860Z',26);
INSERT INTO "answer" VALUES(66,3,'trial/1/misc/misc',1,'trial',1,'misc','misc',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:33.886Z',26);
INSERT INTO "answer" VALUES(67,3,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:49.990Z',28);
INSERT INTO "answer" VALUES(68,3,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,3.65000003300000042116e+00,'participant','2031-07-23T16:48:54.016Z',28);
INSERT INTO "answer" VALUES(69,3,'trial/2/misc/misc',1,'trial',2,'misc','misc',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:58.042Z',28);
INSERT INTO "answer" VALUES(70,3,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:14.146Z',30);
INSERT INTO "answer" VALUES(71,3,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,3.65000003300000042116e+00,'participant','2031-07-23T16:49:18.172Z',30);
INSERT INTO "answer" VALUES(72,3,'trial/3/misc/misc',1,'trial',3,'misc','misc',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:22.198Z',30);
INSERT INTO "answer" VALUES(73,3,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:38.302Z',32);
INSERT INTO "answer" VALUES(74,3,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,3.65000003300000042116e+00,'participant','2031-07-23T16:49:42.328Z',32);
INSERT INTO "answer" VALUES(75,3,'trial/4/misc/misc',1,'trial',4,'misc','misc',4.0,3.65000003300000042116e+00,'participant','2031-07-23T16:49:46.354Z',32);
INSERT INTO "answer" VALUES(76,3,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:02.458Z',34);
INSERT INTO "answer" VALUES(77,3,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,3.65000003300000042116e+00,'participant','2031-07-23T16:50:06.484Z',34);
INSERT INTO "answer" VALUES(78,3,'trial/5/misc/misc',1,'trial',5,'misc','misc',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:10.510Z',34);
INSERT INTO "answer" VALUES(79,3,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:26.614Z',36);
INSERT INTO "answer" VALUES(80,3,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,3.65000003300000042116e+00,'participant','2031-07-23T16:50:30.640Z',36);
INSERT INTO "answer" VALUES(81,3,'trial/6/misc/misc',1,'trial',6,'misc','misc',6.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:34.666Z',36);
INSERT INTO "answer" VALUES(82,3,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',55.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:38.692Z',NULL);
INSERT INTO "answer" VALUES(83,3,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',25.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:42.718Z',NULL);
INSERT INTO "answer" VALUES(84,3,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',20.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:46.744Z',NULL);
INSERT INTO "answer" VALUES(85,3,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',65.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:50.770Z',NULL);
INSERT INTO "answer" VALUES(86,3,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',30.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:54.796Z',NULL);
INSERT INTO "answer" VALUES(87,3,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',55.0,3.65000003300000042116e+00,'participant','2031-07-23T16:50:58.822Z',NULL);
INSERT INTO "answer" VALUES(88,4,'before/demographics/age',1,'before',0,'demographics','age',84.0,4.650000033,'participant','2031-07-23T16:51:12.913Z',NULL);
INSERT INTO "answer" VALUES(89,4,'before/demographics/gender',1,'before',0,'demographics','gender',1.0,4.650000033,'participant','2031-07-23T16:51:16.939Z',NULL);
INSERT INTO "answer" VALUES(90,4,'before/demographics/vision',1,'before',0,'demographics','vision',1.0,4.650000033,'participant','2031-07-23T16:51:20.965Z',NULL);
INSERT INTO "answer" VALUES(91,4,'before/demographics/headsets',1,'before',0,'demographics','headsets',1.0,4.650000033,'participant','2031-07-23T16:51:24.991Z',NULL);
INSERT INTO "answer" VALUES(92,4,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'participant','2031-07-23T16:51:47.134Z',39);
INSERT INTO "answer" VALUES(93,4,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',1.0,4.650000033,'participant','2031-07-23T16:51:51.160Z',39);
INSERT INTO "answer" VALUES(94,4,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,4.650000033,'participant','2031-07-23T16:51:55.186Z',39);
INSERT INTO "answer" VALUES(95,4,'trial/1/misc/misc',1,'trial',1,'misc','misc',2.0,4.650000033,'participant','2031-07-23T16:51:59.212Z',39);
INSERT INTO "answer" VALUES(96,4,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',3.0,4.650000033,'participant','2031-07-23T16:52:15.316Z',41);
INSERT INTO "answer" VALUES(97,4,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,4.650000033,'participant','2031-07-23T16:52:19.342Z',41);
INSERT INTO "answer" VALUES(98,4,'trial/2/misc/misc',1,'trial',2,'misc','misc',3.0,4.650000033,'participant','2031-07-23T16:52:23.368Z',41);
INSERT INTO "answer" VALUES(99,4,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',1.0,4.650000033,'participant','2031-07-23T16:52:39.472Z',43);
INSERT INTO "answer" VALUES(100,4,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,4.650000033,'participant','2031-07-23T16:52:43.498Z',43);
INSERT INTO "answer" VALUES(101,4,'trial/3/misc/misc',1,'trial',3,'misc','misc',4.0,4.650000033,'participant','2031-07-23T16:52:47.524Z',43);
INSERT INTO "answer" VALUES(102,4,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',1.0,4.650000033,'participant','2031-07-23T16:53:03.628Z',45);
INSERT INTO "answer" VALUES(103,4,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,4.650000033,'participant','2031-07-23T16:53:07.654Z',45);
INSERT INTO "answer" VALUES(104,4,'trial/4/misc/misc',1,'trial',4,'misc','misc',5.0,4.650000033,'participant','2031-07-23T16:53:11.680Z',45);
INSERT INTO "answer" VALUES(105,4,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',2.0,4.650000033,'participant','2031-07-23T16:53:27.784Z',47);
INSERT INTO "answer" VALUES(106,4,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,4.650000033,'participant','2031-07-23T16:53:31.810Z',47);
INSERT INTO "answer" VALUES(107,4,'trial/5/misc/misc',1,'trial',5,'misc','misc',6.0,4.650000033,'participant','2031-07-23T16:53:35.836Z',47);
INSERT INTO "answer" VALUES(108,4,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',1.0,4.650000033,'participant','2031-07-23T16:53:51.940Z',49);
INSERT INTO "answer" VALUES(109,4,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,4.650000033,'participant','2031-07-23T16:53:55.966Z',49);
INSERT INTO "answer" VALUES(110,4,'trial/6/misc/misc',1,'trial',6,'misc','misc',7.0,4.650000033,'participant','2031-07-23T16:53:59.992Z',49);
INSERT INTO "answer" VALUES(111,4,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',70.0,4.650000033,'participant','2031-07-23T16:54:04.018Z',NULL);
INSERT INTO "answer" VALUES(112,4,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',75.0,4.650000033,'participant','2031-07-23T16:54:08.044Z',NULL);
INSERT INTO "answer" VALUES(113,4,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',0.0,4.650000033,'participant','2031-07-23T16:54:12.070Z',NULL);
INSERT INTO "answer" VALUES(114,4,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',10.0,4.650000033,'participant','2031-07-23T16:54:16.096Z',NULL);
INSERT INTO "answer" VALUES(115,4,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',45.0,4.650000033,'participant','2031-07-23T16:54:20.122Z',NULL);
INSERT INTO "answer" VALUES(116,4,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',40.0,4.650000033,'participant','2031-07-23T16:54:24.148Z',NULL);
INSERT INTO "answer" VALUES(117,5,'before/demographics/age',1,'before',0,'demographics','age',77.0,5.650000033,'participant','2031-07-23T16:54:38.239Z',NULL);
INSERT INTO "answer" VALUES(118,5,'before/demographics/gender',1,'before',0,'demographics','gender',4.0,5.650000033,'participant','2031-07-23T16:54:42.265Z',NULL);
INSERT INTO "answer" VALUES(119,5,'before/demographics/vision',1,'before',0,'demographics','vision',3.0,5.650000033,'participant','2031-07-23T16:54:46.291Z',NULL);
INSERT INTO "answer" VALUES(120,5,'before/demographics/headsets',1,'before',0,'demographics','headsets',3.0,5.650000033,'participant','2031-07-23T16:54:50.317Z',NULL);
INSERT INTO "answer" VALUES(121,5,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'participant','2031-07-23T16:55:06.421Z',51);
INSERT INTO "answer" VALUES(122,5,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',3.0,5.650000033,'participant','2031-07-23T16:55:10.447Z',51);
INSERT INTO "answer" VALUES(123,5,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,5.650000033,'participant','2031-07-23T16:55:14.473Z',51);
INSERT INTO "answer" VALUES(124,5,'trial/1/misc/misc',1,'trial',1,'misc','misc',1.0,5.650000033,'participant','2031-07-23T16:55:18.499Z',51);
INSERT INTO "answer" VALUES(125,5,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',3.0,5.650000033,'participant','2031-07-23T16:55:34.603Z',53);
INSERT INTO "answer" VALUES(126,5,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,5.650000033,'participant','2031-07-23T16:55:38.629Z',53);
INSERT INTO "answer" VALUES(127,5,'trial/2/misc/misc',1,'trial',2,'misc','misc',2.0,5.650000033,'participant','2031-07-23T16:55:42.655Z',53);
INSERT INTO "answer" VALUES(128,5,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',2.0,5.650000033,'participant','2031-07-23T16:55:58.759Z',55);
INSERT INTO "answer" VALUES(129,5,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,5.650000033,'participant','2031-07-23T16:56:02.785Z',55);
INSERT INTO "answer" VALUES(130,5,'trial/3/misc/misc',1,'trial',3,'misc','misc',3.0,5.650000033,'participant','2031-07-23T16:56:06.811Z',55);
INSERT INTO "answer" VALUES(131,5,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',1.0,5.650000033,'participant','2031-07-23T16:56:22.915Z',57);
INSERT INTO "answer" VALUES(132,5,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,5.650000033,'participant','2031-07-23T16:56:26.941Z',57);
INSERT INTO "answer" VALUES(133,5,'trial/4/misc/misc',1,'trial',4,'misc','misc',4.0,5.650000033,'participant','2031-07-23T16:56:30.967Z',57);
INSERT INTO "answer" VALUES(134,5,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',2.0,5.650000033,'participant','2031-07-23T16:56:47.071Z',59);
INSERT INTO "answer" VALUES(135,5,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,5.650000033,'participant','2031-07-23T16:56:51.097Z',59);
INSERT INTO "answer" VALUES(136,5,'trial/5/misc/misc',1,'trial',5,'misc','misc',5.0,5.650000033,'participant','2031-07-23T16:56:55.123Z',59);
INSERT INTO "answer" VALUES(137,5,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',2.0,5.650000033,'participant','2031-07-23T16:57:11.227Z',61);
INSERT INTO "answer" VALUES(138,5,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,5.650000033,'participant','2031-07-23T16:57:15.253Z',61);
INSERT INTO "answer" VALUES(139,5,'trial/6/misc/misc',1,'trial',6,'misc','misc',6.0,5.650000033,'participant','2031-07-23T16:57:19.279Z',61);
INSERT INTO "answer" VALUES(140,5,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',70.0,5.650000033,'participant','2031-07-23T16:57:23.305Z',NULL);
INSERT INTO "answer" VALUES(141,5,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',90.0,5.650000033,'participant','2031-07-23T16:57:27.331Z',NULL);
INSERT INTO "answer" VALUES(142,5,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',20.0,5.650000033,'participant','2031-07-23T16:57:31.357Z',NULL);
INSERT INTO "answer" VALUES(143,5,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',55.0,5.650000033,'participant','2031-07-23T16:57:35.383Z',NULL);
INSERT INTO "answer" VALUES(144,5,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',35.0,5.650000033,'participant','2031-07-23T16:57:39.409Z',NULL);
INSERT INTO "answer" VALUES(145,5,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',90.0,5.650000033,'participant','2031-07-23T16:57:43.435Z',NULL);
INSERT INTO "answer" VALUES(146,6,'before/demographics/age',1,'before',0,'demographics','age',72.0,6.650000033,'participant','2031-07-23T16:57:57.526Z',NULL);
INSERT INTO "answer" VALUES(147,6,'before/demographics/gender',1,'before',0,'demographics','gender',4.0,6.650000033,'participant','2031-07-23T16:58:01.552Z',NULL);
INSERT INTO "answer" VALUES(148,6,'before/demographics/vision',1,'before',0,'demographics','vision',1.0,6.650000033,'participant','2031-07-23T16:58:05.578Z',NULL);
INSERT INTO "answer" VALUES(149,6,'before/demographics/headsets',1,'before',0,'demographics','headsets',4.0,6.650000033,'participant','2031-07-23T16:58:09.604Z',NULL);
INSERT INTO "answer" VALUES(150,6,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'participant','2031-07-23T16:58:25.708Z',63);
INSERT INTO "answer" VALUES(151,6,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',2.0,6.650000033,'participant','2031-07-23T16:58:29.734Z',63);
INSERT INTO "answer" VALUES(152,6,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,6.650000033,'participant','2031-07-23T16:58:33.760Z',63);
INSERT INTO "answer" VALUES(153,6,'trial/1/misc/misc',1,'trial',1,'misc','misc',2.0,6.650000033,'participant','2031-07-23T16:58:37.786Z',63);
INSERT INTO "answer" VALUES(154,6,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',2.0,6.650000033,'participant','2031-07-23T16:58:53.890Z',65);
INSERT INTO "answer" VALUES(155,6,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,6.650000033,'participant','2031-07-23T16:58:57.916Z',65);
INSERT INTO "answer" VALUES(156,6,'trial/2/misc/misc',1,'trial',2,'misc','misc',3.0,6.650000033,'participant','2031-07-23T16:59:01.942Z',65);
INSERT INTO "answer" VALUES(157,6,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',3.0,6.650000033,'participant','2031-07-23T16:59:18.046Z',67);
INSERT INTO "answer" VALUES(158,6,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,6.650000033,'participant','2031-07-23T16:59:22.072Z',67);
INSERT INTO "answer" VALUES(159,6,'trial/3/misc/misc',1,'trial',3,'misc','misc',4.0,6.650000033,'participant','2031-07-23T16:59:26.098Z',67);
INSERT INTO "answer" VALUES(160,6,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',1.0,6.650000033,'participant','2031-07-23T16:59:42.202Z',69);
INSERT INTO "answer" VALUES(161,6,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,6.650000033,'participant','2031-07-23T16:59:46.228Z',69);
INSERT INTO "answer" VALUES(162,6,'trial/4/misc/misc',1,'trial',4,'misc','misc',5.0,6.650000033,'participant','2031-07-23T16:59:50.254Z',69);
INSERT INTO "answer" VALUES(163,6,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',2.0,6.650000033,'participant','2031-07-23T17:00:06.358Z',71);
INSERT INTO "answer" VALUES(164,6,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,6.650000033,'participant','2031-07-23T17:00:10.384Z',71);
INSERT INTO "answer" VALUES(165,6,'trial/5/misc/misc',1,'trial',5,'misc','misc',6.0,6.650000033,'participant','2031-07-23T17:00:14.410Z',71);
INSERT INTO "answer" VALUES(166,6,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',1.0,6.650000033,'participant','2031-07-23T17:00:30.514Z',73);
INSERT INTO "answer" VALUES(167,6,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,6.650000033,'participant','2031-07-23T17:00:34.540Z',73);
INSERT INTO "answer" VALUES(168,6,'trial/6/misc/misc',1,'trial',6,'misc','misc',7.0,6.650000033,'participant','2031-07-23T17:00:38.566Z',73);
INSERT INTO "answer" VALUES(169,6,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',0.0,6.650000033,'participant','2031-07-23T17:00:42.592Z',NULL);
INSERT INTO "answer" VALUES(170,6,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',5.0,6.650000033,'participant','2031-07-23T17:00:46.618Z',NULL);
INSERT INTO "answer" VALUES(171,6,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',15.0,6.650000033,'participant','2031-07-23T17:00:50.644Z',NULL);
INSERT INTO "answer" VALUES(172,6,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',100.0,6.650000033,'participant','2031-07-23T17:00:54.670Z',NULL);
INSERT INTO "answer" VALUES(173,6,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',20.0,6.650000033,'participant','2031-07-23T17:00:58.696Z',NULL);
INSERT INTO "answer" VALUES(174,6,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',65.0,6.650000033,'participant','2031-07-23T17:01:02.722Z',NULL);
INSERT INTO "answer" VALUES(175,7,'before/demographics/age',1,'before',0,'demographics','age',53.0,7.650000033,'participant','2031-07-23T17:01:16.813Z',NULL);
INSERT INTO "answer" VALUES(176,7,'before/demographics/gender',1,'before',0,'demographics','gender',3.0,7.650000033,'participant','2031-07-23T17:01:20.839Z',NULL);
INSERT INTO "answer" VALUES(177,7,'before/demographics/vision',1,'before',0,'demographics','vision',2.0,7.650000033,'participant','2031-07-23T17:01:24.865Z',NULL);
INSERT INTO "answer" VALUES(178,7,'before/demographics/headsets',1,'before',0,'demographics','headsets',2.0,7.650000033,'participant','2031-07-23T17:01:28.891Z',NULL);
INSERT INTO "answer" VALUES(179,7,'trial/1/preference_or_tie/better',1,'trial',1,'preference_or_tie','better',1.0,0.5,'participant','2031-07-23T17:01:44.995Z',75);
INSERT INTO "answer" VALUES(180,7,'trial/1/preference_or_tie/better',2,'trial',1,'preference_or_tie','better',3.0,7.650000033,'participant','2031-07-23T17:01:49.021Z',75);
INSERT INTO "answer" VALUES(181,7,'trial/1/comments/comments',1,'trial',1,'comments','comments',NULL,7.650000033,'participant','2031-07-23T17:01:53.047Z',75);
INSERT INTO "answer" VALUES(182,7,'trial/1/misc/misc',1,'trial',1,'misc','misc',1.0,7.650000033,'participant','2031-07-23T17:01:57.073Z',75);
INSERT INTO "answer" VALUES(183,7,'trial/2/preference_or_tie/better',1,'trial',2,'preference_or_tie','better',2.0,7.650000033,'participant','2031-07-23T17:02:13.177Z',77);
INSERT INTO "answer" VALUES(184,7,'trial/2/comments/comments',1,'trial',2,'comments','comments',NULL,7.650000033,'participant','2031-07-23T17:02:17.203Z',77);
INSERT INTO "answer" VALUES(185,7,'trial/2/misc/misc',1,'trial',2,'misc','misc',2.0,7.650000033,'participant','2031-07-23T17:02:21.229Z',77);
INSERT INTO "answer" VALUES(186,7,'trial/3/preference_or_tie/better',1,'trial',3,'preference_or_tie','better',2.0,7.650000033,'participant','2031-07-23T17:02:37.333Z',79);
INSERT INTO "answer" VALUES(187,7,'trial/3/comments/comments',1,'trial',3,'comments','comments',NULL,7.650000033,'participant','2031-07-23T17:02:41.359Z',79);
INSERT INTO "answer" VALUES(188,7,'trial/3/misc/misc',1,'trial',3,'misc','misc',3.0,7.650000033,'participant','2031-07-23T17:02:45.385Z',79);
INSERT INTO "answer" VALUES(189,7,'trial/4/preference_or_tie/better',1,'trial',4,'preference_or_tie','better',1.0,7.650000033,'participant','2031-07-23T17:03:01.489Z',81);
INSERT INTO "answer" VALUES(190,7,'trial/4/comments/comments',1,'trial',4,'comments','comments',NULL,7.650000033,'participant','2031-07-23T17:03:05.515Z',81);
INSERT INTO "answer" VALUES(191,7,'trial/4/misc/misc',1,'trial',4,'misc','misc',4.0,7.650000033,'participant','2031-07-23T17:03:09.541Z',81);
INSERT INTO "answer" VALUES(192,7,'trial/5/preference_or_tie/better',1,'trial',5,'preference_or_tie','better',2.0,7.650000033,'participant','2031-07-23T17:03:25.645Z',83);
INSERT INTO "answer" VALUES(193,7,'trial/5/comments/comments',1,'trial',5,'comments','comments',NULL,7.650000033,'participant','2031-07-23T17:03:29.671Z',83);
INSERT INTO "answer" VALUES(194,7,'trial/5/misc/misc',1,'trial',5,'misc','misc',5.0,7.650000033,'participant','2031-07-23T17:03:33.697Z',83);
INSERT INTO "answer" VALUES(195,7,'trial/6/preference_or_tie/better',1,'trial',6,'preference_or_tie','better',3.0,7.650000033,'participant','2031-07-23T17:03:49.801Z',85);
INSERT INTO "answer" VALUES(196,7,'trial/6/comments/comments',1,'trial',6,'comments','comments',NULL,7.650000033,'participant','2031-07-23T17:03:53.827Z',85);
INSERT INTO "answer" VALUES(197,7,'trial/6/misc/misc',1,'trial',6,'misc','misc',6.0,7.650000033,'participant','2031-07-23T17:03:57.853Z',85);
INSERT INTO "answer" VALUES(198,7,'after/nasa_tlx/mental',1,'after',0,'nasa_tlx','mental',70.0,7.650000033,'participant','2031-07-23T17:04:01.879Z',NULL);
INSERT INTO "answer" VALUES(199,7,'after/nasa_tlx/physical',1,'after',0,'nasa_tlx','physical',70.0,7.650000033,'participant','2031-07-23T17:04:05.905Z',NULL);
INSERT INTO "answer" VALUES(200,7,'after/nasa_tlx/temporal',1,'after',0,'nasa_tlx','temporal',45.0,7.650000033,'participant','2031-07-23T17:04:09.931Z',NULL);
INSERT INTO "answer" VALUES(201,7,'after/nasa_tlx/performance',1,'after',0,'nasa_tlx','performance',10.0,7.650000033,'participant','2031-07-23T17:04:13.957Z',NULL);
INSERT INTO "answer" VALUES(202,7,'after/nasa_tlx/effort',1,'after',0,'nasa_tlx','effort',60.0,7.650000033,'participant','2031-07-23T17:04:17.983Z',NULL);
INSERT INTO "answer" VALUES(203,7,'after/nasa_tlx/frustration',1,'after',0,'nasa_tlx','frustration',5.0,7.650000033,'participant','2031-07-23T17:04:22.009Z',NULL);
CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  kind TEXT NOT NULL,
  key TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  mono_ns INTEGER NOT NULL,
  data TEXT NOT NULL
) STRICT;
INSERT INTO "event" VALUES(1,1,'begin','','2031-07-23T16:41:13.039Z',2013000000,'{"part":"main","row":10,"plan_text_changed":false}');
INSERT INTO "event" VALUES(2,1,'answer','before/demographics/age','2031-07-23T16:41:17.065Z',4026000000,'{"value":87.0,"revision":1}');
INSERT INTO "event" VALUES(3,1,'answer','before/demographics/gender','2031-07-23T16:41:21.091Z',6039000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(4,1,'answer','before/demographics/vision','2031-07-23T16:41:25.117Z',8052000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(5,1,'answer','before/demographics/headsets','2031-07-23T16:41:29.143Z',10065000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(6,1,'showing','trial/1/first','2031-07-23T16:41:33.169Z',12078000000,'{"showing":1,"presentation":1}');
INSERT INTO "event" VALUES(7,1,'shown','trial/1/first','2031-07-23T16:41:35.182Z',14091000000,'{"showing":1,"complete":true}');
INSERT INTO "event" VALUES(8,1,'showing','trial/1/second','2031-07-23T16:41:39.208Z',16104000000,'{"showing":2,"presentation":1}');
INSERT INTO "event" VALUES(9,1,'shown','trial/1/second','2031-07-23T16:41:41.221Z',18117000000,'{"showing":2,"complete":true}');
INSERT INTO "event" VALUES(10,1,'answer','trial/1/preference_or_tie/better','2031-07-23T16:41:45.247Z',20130000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(11,1,'answer','trial/1/preference_or_tie/better','2031-07-23T16:41:49.273Z',22143000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(12,1,'answer','trial/1/comments/comments','2031-07-23T16:41:53.299Z',24156000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(13,1,'answer','trial/1/misc/misc','2031-07-23T16:41:57.325Z',26169000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(14,1,'showing','trial/2/first','2031-07-23T16:42:01.351Z',28182000000,'{"showing":3,"presentation":1}');
INSERT INTO "event" VALUES(15,1,'shown','trial/2/first','2031-07-23T16:42:03.364Z',30195000000,'{"showing":3,"complete":true}');
INSERT INTO "event" VALUES(16,1,'showing','trial/2/second','2031-07-23T16:42:07.390Z',32208000000,'{"showing":4,"presentation":1}');
INSERT INTO "event" VALUES(17,1,'shown','trial/2/second','2031-07-23T16:42:09.403Z',34221000000,'{"showing":4,"complete":true}');
INSERT INTO "event" VALUES(18,1,'answer','trial/2/preference_or_tie/better','2031-07-23T16:42:13.429Z',36234000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(19,1,'answer','trial/2/comments/comments','2031-07-23T16:42:17.455Z',38247000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(20,1,'answer','trial/2/misc/misc','2031-07-23T16:42:21.481Z',40260000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(21,1,'showing','trial/3/first','2031-07-23T16:42:25.507Z',42273000000,'{"showing":5,"presentation":1}');
INSERT INTO "event" VALUES(22,1,'shown','trial/3/first','2031-07-23T16:42:27.520Z',44286000000,'{"showing":5,"complete":true}');
INSERT INTO "event" VALUES(23,1,'showing','trial/3/second','2031-07-23T16:42:31.546Z',46299000000,'{"showing":6,"presentation":1}');
INSERT INTO "event" VALUES(24,1,'shown','trial/3/second','2031-07-23T16:42:33.559Z',48312000000,'{"showing":6,"complete":true}');
INSERT INTO "event" VALUES(25,1,'answer','trial/3/preference_or_tie/better','2031-07-23T16:42:37.585Z',50325000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(26,1,'answer','trial/3/comments/comments','2031-07-23T16:42:41.611Z',52338000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(27,1,'answer','trial/3/misc/misc','2031-07-23T16:42:45.637Z',54351000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(28,1,'showing','trial/4/first','2031-07-23T16:42:49.663Z',56364000000,'{"showing":7,"presentation":1}');
INSERT INTO "event" VALUES(29,1,'shown','trial/4/first','2031-07-23T16:42:51.676Z',58377000000,'{"showing":7,"complete":true}');
INSERT INTO "event" VALUES(30,1,'showing','trial/4/second','2031-07-23T16:42:55.702Z',60390000000,'{"showing":8,"presentation":1}');
INSERT INTO "event" VALUES(31,1,'shown','trial/4/second','2031-07-23T16:42:57.715Z',62403000000,'{"showing":8,"complete":true}');
INSERT INTO "event" VALUES(32,1,'answer','trial/4/preference_or_tie/better','2031-07-23T16:43:01.741Z',64416000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(33,1,'answer','trial/4/comments/comments','2031-07-23T16:43:05.767Z',66429000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(34,1,'answer','trial/4/misc/misc','2031-07-23T16:43:09.793Z',68442000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(35,1,'showing','trial/5/first','2031-07-23T16:43:13.819Z',70455000000,'{"showing":9,"presentation":1}');
INSERT INTO "event" VALUES(36,1,'shown','trial/5/first','2031-07-23T16:43:15.832Z',72468000000,'{"showing":9,"complete":true}');
INSERT INTO "event" VALUES(37,1,'showing','trial/5/second','2031-07-23T16:43:19.858Z',74481000000,'{"showing":10,"presentation":1}');
INSERT INTO "event" VALUES(38,1,'shown','trial/5/second','2031-07-23T16:43:21.871Z',76494000000,'{"showing":10,"complete":true}');
INSERT INTO "event" VALUES(39,1,'answer','trial/5/preference_or_tie/better','2031-07-23T16:43:25.897Z',78507000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(40,1,'answer','trial/5/comments/comments','2031-07-23T16:43:29.923Z',80520000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(41,1,'answer','trial/5/misc/misc','2031-07-23T16:43:33.949Z',82533000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(42,1,'showing','trial/6/first','2031-07-23T16:43:37.975Z',84546000000,'{"showing":11,"presentation":1}');
INSERT INTO "event" VALUES(43,1,'shown','trial/6/first','2031-07-23T16:43:39.988Z',86559000000,'{"showing":11,"complete":true}');
INSERT INTO "event" VALUES(44,1,'showing','trial/6/second','2031-07-23T16:43:44.014Z',88572000000,'{"showing":12,"presentation":1}');
INSERT INTO "event" VALUES(45,1,'shown','trial/6/second','2031-07-23T16:43:46.027Z',90585000000,'{"showing":12,"complete":true}');
INSERT INTO "event" VALUES(46,1,'answer','trial/6/preference_or_tie/better','2031-07-23T16:43:50.053Z',92598000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(47,1,'answer','trial/6/comments/comments','2031-07-23T16:43:54.079Z',94611000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(48,1,'answer','trial/6/misc/misc','2031-07-23T16:43:58.105Z',96624000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(49,1,'answer','after/nasa_tlx/mental','2031-07-23T16:44:02.131Z',98637000000,'{"value":65.0,"revision":1}');
INSERT INTO "event" VALUES(50,1,'answer','after/nasa_tlx/physical','2031-07-23T16:44:06.157Z',100650000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(51,1,'answer','after/nasa_tlx/temporal','2031-07-23T16:44:10.183Z',102663000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(52,1,'answer','after/nasa_tlx/performance','2031-07-23T16:44:14.209Z',104676000000,'{"value":95.0,"revision":1}');
INSERT INTO "event" VALUES(53,1,'answer','after/nasa_tlx/effort','2031-07-23T16:44:18.235Z',106689000000,'{"value":25.0,"revision":1}');
INSERT INTO "event" VALUES(54,1,'answer','after/nasa_tlx/frustration','2031-07-23T16:44:22.261Z',108702000000,'{"value":85.0,"revision":1}');
INSERT INTO "event" VALUES(55,1,'remark','trial/1','2031-07-23T16:44:24.274Z',110715000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(56,1,'end','','2031-07-23T16:44:26.287Z',112728000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(57,2,'begin','','2031-07-23T16:44:32.326Z',114741000000,'{"part":"main","row":5,"plan_text_changed":false}');
INSERT INTO "event" VALUES(58,2,'answer','before/demographics/age','2031-07-23T16:44:36.352Z',116754000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(59,2,'answer','before/demographics/gender','2031-07-23T16:44:40.378Z',118767000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(60,2,'answer','before/demographics/vision','2031-07-23T16:44:44.404Z',120780000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(61,2,'answer','before/demographics/headsets','2031-07-23T16:44:48.430Z',122793000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(62,2,'showing','trial/1/first','2031-07-23T16:44:52.456Z',124806000000,'{"showing":13,"presentation":1}');
INSERT INTO "event" VALUES(63,2,'shown','trial/1/first','2031-07-23T16:44:54.469Z',126819000000,'{"showing":13,"complete":true}');
INSERT INTO "event" VALUES(64,2,'showing','trial/1/second','2031-07-23T16:44:58.495Z',128832000000,'{"showing":14,"presentation":1}');
INSERT INTO "event" VALUES(65,2,'shown','trial/1/second','2031-07-23T16:45:00.508Z',130845000000,'{"showing":14,"complete":true}');
INSERT INTO "event" VALUES(66,2,'answer','trial/1/preference_or_tie/better','2031-07-23T16:45:04.534Z',132858000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(67,2,'answer','trial/1/preference_or_tie/better','2031-07-23T16:45:08.560Z',134871000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(68,2,'answer','trial/1/comments/comments','2031-07-23T16:45:12.586Z',136884000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(69,2,'answer','trial/1/misc/misc','2031-07-23T16:45:16.612Z',138897000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(70,2,'showing','trial/2/first','2031-07-23T16:45:20.638Z',140910000000,'{"showing":15,"presentation":1}');
INSERT INTO "event" VALUES(71,2,'shown','trial/2/first','2031-07-23T16:45:22.651Z',142923000000,'{"showing":15,"complete":true}');
INSERT INTO "event" VALUES(72,2,'showing','trial/2/second','2031-07-23T16:45:26.677Z',144936000000,'{"showing":16,"presentation":1}');
INSERT INTO "event" VALUES(73,2,'shown','trial/2/second','2031-07-23T16:45:28.690Z',146949000000,'{"showing":16,"complete":true}');
INSERT INTO "event" VALUES(74,2,'answer','trial/2/preference_or_tie/better','2031-07-23T16:45:32.716Z',148962000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(75,2,'answer','trial/2/comments/comments','2031-07-23T16:45:36.742Z',150975000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(76,2,'answer','trial/2/misc/misc','2031-07-23T16:45:40.768Z',152988000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(77,2,'showing','trial/3/first','2031-07-23T16:45:44.794Z',155001000000,'{"showing":17,"presentation":1}');
INSERT INTO "event" VALUES(78,2,'shown','trial/3/first','2031-07-23T16:45:46.807Z',157014000000,'{"showing":17,"complete":true}');
INSERT INTO "event" VALUES(79,2,'showing','trial/3/second','2031-07-23T16:45:50.833Z',159027000000,'{"showing":18,"presentation":1}');
INSERT INTO "event" VALUES(80,2,'shown','trial/3/second','2031-07-23T16:45:52.846Z',161040000000,'{"showing":18,"complete":true}');
INSERT INTO "event" VALUES(81,2,'answer','trial/3/preference_or_tie/better','2031-07-23T16:45:56.872Z',163053000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(82,2,'answer','trial/3/comments/comments','2031-07-23T16:46:00.898Z',165066000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(83,2,'answer','trial/3/misc/misc','2031-07-23T16:46:04.924Z',167079000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(84,2,'showing','trial/4/first','2031-07-23T16:46:08.950Z',169092000000,'{"showing":19,"presentation":1}');
INSERT INTO "event" VALUES(85,2,'shown','trial/4/first','2031-07-23T16:46:10.963Z',171105000000,'{"showing":19,"complete":true}');
INSERT INTO "event" VALUES(86,2,'showing','trial/4/second','2031-07-23T16:46:14.989Z',173118000000,'{"showing":20,"presentation":1}');
INSERT INTO "event" VALUES(87,2,'shown','trial/4/second','2031-07-23T16:46:17.002Z',175131000000,'{"showing":20,"complete":true}');
INSERT INTO "event" VALUES(88,2,'answer','trial/4/preference_or_tie/better','2031-07-23T16:46:21.028Z',177144000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(89,2,'answer','trial/4/comments/comments','2031-07-23T16:46:25.054Z',179157000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(90,2,'answer','trial/4/misc/misc','2031-07-23T16:46:29.080Z',181170000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(91,2,'showing','trial/5/first','2031-07-23T16:46:33.106Z',183183000000,'{"showing":21,"presentation":1}');
INSERT INTO "event" VALUES(92,2,'shown','trial/5/first','2031-07-23T16:46:35.119Z',185196000000,'{"showing":21,"complete":true}');
INSERT INTO "event" VALUES(93,2,'showing','trial/5/second','2031-07-23T16:46:39.145Z',187209000000,'{"showing":22,"presentation":1}');
INSERT INTO "event" VALUES(94,2,'shown','trial/5/second','2031-07-23T16:46:41.158Z',189222000000,'{"showing":22,"complete":true}');
INSERT INTO "event" VALUES(95,2,'answer','trial/5/preference_or_tie/better','2031-07-23T16:46:45.184Z',191235000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(96,2,'answer','trial/5/comments/comments','2031-07-23T16:46:49.210Z',193248000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(97,2,'answer','trial/5/misc/misc','2031-07-23T16:46:53.236Z',195261000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(98,2,'showing','trial/6/first','2031-07-23T16:46:57.262Z',197274000000,'{"showing":23,"presentation":1}');
INSERT INTO "event" VALUES(99,2,'shown','trial/6/first','2031-07-23T16:46:59.275Z',199287000000,'{"showing":23,"complete":true}');
INSERT INTO "event" VALUES(100,2,'showing','trial/6/second','2031-07-23T16:47:03.301Z',201300000000,'{"showing":24,"presentation":1}');
INSERT INTO "event" VALUES(101,2,'shown','trial/6/second','2031-07-23T16:47:05.314Z',203313000000,'{"showing":24,"complete":true}');
INSERT INTO "event" VALUES(102,2,'answer','trial/6/preference_or_tie/better','2031-07-23T16:47:09.340Z',205326000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(103,2,'answer','trial/6/comments/comments','2031-07-23T16:47:13.366Z',207339000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(104,2,'answer','trial/6/misc/misc','2031-07-23T16:47:17.392Z',209352000000,'{"value":7.0,"revision":1}');
INSERT INTO "event" VALUES(105,2,'answer','after/nasa_tlx/mental','2031-07-23T16:47:21.418Z',211365000000,'{"value":65.0,"revision":1}');
INSERT INTO "event" VALUES(106,2,'answer','after/nasa_tlx/physical','2031-07-23T16:47:25.444Z',213378000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(107,2,'answer','after/nasa_tlx/temporal','2031-07-23T16:47:29.470Z',215391000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(108,2,'answer','after/nasa_tlx/performance','2031-07-23T16:47:33.496Z',217404000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(109,2,'answer','after/nasa_tlx/effort','2031-07-23T16:47:37.522Z',219417000000,'{"value":90.0,"revision":1}');
INSERT INTO "event" VALUES(110,2,'answer','after/nasa_tlx/frustration','2031-07-23T16:47:41.548Z',221430000000,'{"value":75.0,"revision":1}');
INSERT INTO "event" VALUES(111,2,'remark','trial/1','2031-07-23T16:47:43.561Z',223443000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(112,2,'end','','2031-07-23T16:47:45.574Z',225456000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(113,3,'begin','','2031-07-23T16:47:51.613Z',227469000000,'{"part":"main","row":8,"plan_text_changed":false}');
INSERT INTO "event" VALUES(114,3,'answer','before/demographics/age','2031-07-23T16:47:55.639Z',229482000000,'{"value":86.0,"revision":1}');
INSERT INTO "event" VALUES(115,3,'answer','before/demographics/gender','2031-07-23T16:47:59.665Z',231495000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(116,3,'answer','before/demographics/vision','2031-07-23T16:48:03.691Z',233508000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(117,3,'answer','before/demographics/headsets','2031-07-23T16:48:07.717Z',235521000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(118,3,'showing','trial/1/first','2031-07-23T16:48:11.743Z',237534000000,'{"showing":25,"presentation":1}');
INSERT INTO "event" VALUES(119,3,'shown','trial/1/first','2031-07-23T16:48:13.756Z',239547000000,'{"showing":25,"complete":true}');
INSERT INTO "event" VALUES(120,3,'showing','trial/1/second','2031-07-23T16:48:17.782Z',241560000000,'{"showing":26,"presentation":1}');
INSERT INTO "event" VALUES(121,3,'shown','trial/1/second','2031-07-23T16:48:19.795Z',243573000000,'{"showing":26,"complete":true}');
INSERT INTO "event" VALUES(122,3,'answer','trial/1/preference_or_tie/better','2031-07-23T16:48:23.821Z',245586000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(123,3,'answer','trial/1/preference_or_tie/better','2031-07-23T16:48:27.847Z',247599000000,'{"value":2.0,"revision":2}');
INSERT INTO "event" VALUES(124,3,'answer','trial/1/comments/comments','2031-07-23T16:48:31.873Z',249612000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(125,3,'answer','trial/1/misc/misc','2031-07-23T16:48:35.899Z',251625000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(126,3,'showing','trial/2/first','2031-07-23T16:48:39.925Z',253638000000,'{"showing":27,"presentation":1}');
INSERT INTO "event" VALUES(127,3,'shown','trial/2/first','2031-07-23T16:48:41.938Z',255651000000,'{"showing":27,"complete":true}');
INSERT INTO "event" VALUES(128,3,'showing','trial/2/second','2031-07-23T16:48:45.964Z',257664000000,'{"showing":28,"presentation":1}');
INSERT INTO "event" VALUES(129,3,'shown','trial/2/second','2031-07-23T16:48:47.977Z',259677000000,'{"showing":28,"complete":true}');
INSERT INTO "event" VALUES(130,3,'answer','trial/2/preference_or_tie/better','2031-07-23T16:48:52.003Z',261690000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(131,3,'answer','trial/2/comments/comments','2031-07-23T16:48:56.029Z',263703000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(132,3,'answer','trial/2/misc/misc','2031-07-23T16:49:00.055Z',265716000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(133,3,'showing','trial/3/first','2031-07-23T16:49:04.081Z',267729000000,'{"showing":29,"presentation":1}');
INSERT INTO "event" VALUES(134,3,'shown','trial/3/first','2031-07-23T16:49:06.094Z',269742000000,'{"showing":29,"complete":true}');
INSERT INTO "event" VALUES(135,3,'showing','trial/3/second','2031-07-23T16:49:10.120Z',271755000000,'{"showing":30,"presentation":1}');
INSERT INTO "event" VALUES(136,3,'shown','trial/3/second','2031-07-23T16:49:12.133Z',273768000000,'{"showing":30,"complete":true}');
INSERT INTO "event" VALUES(137,3,'answer','trial/3/preference_or_tie/better','2031-07-23T16:49:16.159Z',275781000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(138,3,'answer','trial/3/comments/comments','2031-07-23T16:49:20.185Z',277794000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(139,3,'answer','trial/3/misc/misc','2031-07-23T16:49:24.211Z',279807000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(140,3,'showing','trial/4/first','2031-07-23T16:49:28.237Z',281820000000,'{"showing":31,"presentation":1}');
INSERT INTO "event" VALUES(141,3,'shown','trial/4/first','2031-07-23T16:49:30.250Z',283833000000,'{"showing":31,"complete":true}');
INSERT INTO "event" VALUES(142,3,'showing','trial/4/second','2031-07-23T16:49:34.276Z',285846000000,'{"showing":32,"presentation":1}');
INSERT INTO "event" VALUES(143,3,'shown','trial/4/second','2031-07-23T16:49:36.289Z',287859000000,'{"showing":32,"complete":true}');
INSERT INTO "event" VALUES(144,3,'answer','trial/4/preference_or_tie/better','2031-07-23T16:49:40.315Z',289872000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(145,3,'answer','trial/4/comments/comments','2031-07-23T16:49:44.341Z',291885000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(146,3,'answer','trial/4/misc/misc','2031-07-23T16:49:48.367Z',293898000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(147,3,'showing','trial/5/first','2031-07-23T16:49:52.393Z',295911000000,'{"showing":33,"presentation":1}');
INSERT INTO "event" VALUES(148,3,'shown','trial/5/first','2031-07-23T16:49:54.406Z',297924000000,'{"showing":33,"complete":true}');
INSERT INTO "event" VALUES(149,3,'showing','trial/5/second','2031-07-23T16:49:58.432Z',299937000000,'{"showing":34,"presentation":1}');
INSERT INTO "event" VALUES(150,3,'shown','trial/5/second','2031-07-23T16:50:00.445Z',301950000000,'{"showing":34,"complete":true}');
INSERT INTO "event" VALUES(151,3,'answer','trial/5/preference_or_tie/better','2031-07-23T16:50:04.471Z',303963000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(152,3,'answer','trial/5/comments/comments','2031-07-23T16:50:08.497Z',305976000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(153,3,'answer','trial/5/misc/misc','2031-07-23T16:50:12.523Z',307989000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(154,3,'showing','trial/6/first','2031-07-23T16:50:16.549Z',310002000000,'{"showing":35,"presentation":1}');
INSERT INTO "event" VALUES(155,3,'shown','trial/6/first','2031-07-23T16:50:18.562Z',312015000000,'{"showing":35,"complete":true}');
INSERT INTO "event" VALUES(156,3,'showing','trial/6/second','2031-07-23T16:50:22.588Z',314028000000,'{"showing":36,"presentation":1}');
INSERT INTO "event" VALUES(157,3,'shown','trial/6/second','2031-07-23T16:50:24.601Z',316041000000,'{"showing":36,"complete":true}');
INSERT INTO "event" VALUES(158,3,'answer','trial/6/preference_or_tie/better','2031-07-23T16:50:28.627Z',318054000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(159,3,'answer','trial/6/comments/comments','2031-07-23T16:50:32.653Z',320067000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(160,3,'answer','trial/6/misc/misc','2031-07-23T16:50:36.679Z',322080000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(161,3,'answer','after/nasa_tlx/mental','2031-07-23T16:50:40.705Z',324093000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(162,3,'answer','after/nasa_tlx/physical','2031-07-23T16:50:44.731Z',326106000000,'{"value":25.0,"revision":1}');
INSERT INTO "event" VALUES(163,3,'answer','after/nasa_tlx/temporal','2031-07-23T16:50:48.757Z',328119000000,'{"value":20.0,"revision":1}');
INSERT INTO "event" VALUES(164,3,'answer','after/nasa_tlx/performance','2031-07-23T16:50:52.783Z',330132000000,'{"value":65.0,"revision":1}');
INSERT INTO "event" VALUES(165,3,'answer','after/nasa_tlx/effort','2031-07-23T16:50:56.809Z',332145000000,'{"value":30.0,"revision":1}');
INSERT INTO "event" VALUES(166,3,'answer','after/nasa_tlx/frustration','2031-07-23T16:51:00.835Z',334158000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(167,3,'remark','trial/1','2031-07-23T16:51:02.848Z',336171000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(168,3,'end','','2031-07-23T16:51:04.861Z',338184000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(169,4,'begin','','2031-07-23T16:51:10.900Z',340197000000,'{"part":"main","row":11,"plan_text_changed":false}');
INSERT INTO "event" VALUES(170,4,'answer','before/demographics/age','2031-07-23T16:51:14.926Z',342210000000,'{"value":84.0,"revision":1}');
INSERT INTO "event" VALUES(171,4,'answer','before/demographics/gender','2031-07-23T16:51:18.952Z',344223000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(172,4,'answer','before/demographics/vision','2031-07-23T16:51:22.978Z',346236000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(173,4,'answer','before/demographics/headsets','2031-07-23T16:51:27.004Z',348249000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(174,4,'showing','trial/1/first','2031-07-23T16:51:31.030Z',350262000000,'{"showing":37,"presentation":1}');
INSERT INTO "event" VALUES(175,4,'shown','trial/1/first','2031-07-23T16:51:33.043Z',352275000000,'{"showing":37,"complete":false}');
INSERT INTO "event" VALUES(176,4,'showing','trial/1/first','2031-07-23T16:51:37.069Z',354288000000,'{"showing":38,"presentation":2}');
INSERT INTO "event" VALUES(177,4,'shown','trial/1/first','2031-07-23T16:51:39.082Z',356301000000,'{"showing":38,"complete":true}');
INSERT INTO "event" VALUES(178,4,'showing','trial/1/second','2031-07-23T16:51:43.108Z',358314000000,'{"showing":39,"presentation":1}');
INSERT INTO "event" VALUES(179,4,'shown','trial/1/second','2031-07-23T16:51:45.121Z',360327000000,'{"showing":39,"complete":true}');
INSERT INTO "event" VALUES(180,4,'answer','trial/1/preference_or_tie/better','2031-07-23T16:51:49.147Z',362340000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(181,4,'answer','trial/1/preference_or_tie/better','2031-07-23T16:51:53.173Z',364353000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(182,4,'answer','trial/1/comments/comments','2031-07-23T16:51:57.199Z',366366000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(183,4,'answer','trial/1/misc/misc','2031-07-23T16:52:01.225Z',368379000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(184,4,'showing','trial/2/first','2031-07-23T16:52:05.251Z',370392000000,'{"showing":40,"presentation":1}');
INSERT INTO "event" VALUES(185,4,'shown','trial/2/first','2031-07-23T16:52:07.264Z',372405000000,'{"showing":40,"complete":true}');
INSERT INTO "event" VALUES(186,4,'showing','trial/2/second','2031-07-23T16:52:11.290Z',374418000000,'{"showing":41,"presentation":1}');
INSERT INTO "event" VALUES(187,4,'shown','trial/2/second','2031-07-23T16:52:13.303Z',376431000000,'{"showing":41,"complete":true}');
INSERT INTO "event" VALUES(188,4,'answer','trial/2/preference_or_tie/better','2031-07-23T16:52:17.329Z',378444000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(189,4,'answer','trial/2/comments/comments','2031-07-23T16:52:21.355Z',380457000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(190,4,'answer','trial/2/misc/misc','2031-07-23T16:52:25.381Z',382470000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(191,4,'showing','trial/3/first','2031-07-23T16:52:29.407Z',384483000000,'{"showing":42,"presentation":1}');
INSERT INTO "event" VALUES(192,4,'shown','trial/3/first','2031-07-23T16:52:31.420Z',386496000000,'{"showing":42,"complete":true}');
INSERT INTO "event" VALUES(193,4,'showing','trial/3/second','2031-07-23T16:52:35.446Z',388509000000,'{"showing":43,"presentation":1}');
INSERT INTO "event" VALUES(194,4,'shown','trial/3/second','2031-07-23T16:52:37.459Z',390522000000,'{"showing":43,"complete":true}');
INSERT INTO "event" VALUES(195,4,'answer','trial/3/preference_or_tie/better','2031-07-23T16:52:41.485Z',392535000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(196,4,'answer','trial/3/comments/comments','2031-07-23T16:52:45.511Z',394548000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(197,4,'answer','trial/3/misc/misc','2031-07-23T16:52:49.537Z',396561000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(198,4,'showing','trial/4/first','2031-07-23T16:52:53.563Z',398574000000,'{"showing":44,"presentation":1}');
INSERT INTO "event" VALUES(199,4,'shown','trial/4/first','2031-07-23T16:52:55.576Z',400587000000,'{"showing":44,"complete":true}');
INSERT INTO "event" VALUES(200,4,'showing','trial/4/second','2031-07-23T16:52:59.602Z',402600000000,'{"showing":45,"presentation":1}');
INSERT INTO "event" VALUES(201,4,'shown','trial/4/second','2031-07-23T16:53:01.615Z',404613000000,'{"showing":45,"complete":true}');
INSERT INTO "event" VALUES(202,4,'answer','trial/4/preference_or_tie/better','2031-07-23T16:53:05.641Z',406626000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(203,4,'answer','trial/4/comments/comments','2031-07-23T16:53:09.667Z',408639000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(204,4,'answer','trial/4/misc/misc','2031-07-23T16:53:13.693Z',410652000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(205,4,'showing','trial/5/first','2031-07-23T16:53:17.719Z',412665000000,'{"showing":46,"presentation":1}');
INSERT INTO "event" VALUES(206,4,'shown','trial/5/first','2031-07-23T16:53:19.732Z',414678000000,'{"showing":46,"complete":true}');
INSERT INTO "event" VALUES(207,4,'showing','trial/5/second','2031-07-23T16:53:23.758Z',416691000000,'{"showing":47,"presentation":1}');
INSERT INTO "event" VALUES(208,4,'shown','trial/5/second','2031-07-23T16:53:25.771Z',418704000000,'{"showing":47,"complete":true}');
INSERT INTO "event" VALUES(209,4,'answer','trial/5/preference_or_tie/better','2031-07-23T16:53:29.797Z',420717000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(210,4,'answer','trial/5/comments/comments','2031-07-23T16:53:33.823Z',422730000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(211,4,'answer','trial/5/misc/misc','2031-07-23T16:53:37.849Z',424743000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(212,4,'showing','trial/6/first','2031-07-23T16:53:41.875Z',426756000000,'{"showing":48,"presentation":1}');
INSERT INTO "event" VALUES(213,4,'shown','trial/6/first','2031-07-23T16:53:43.888Z',428769000000,'{"showing":48,"complete":true}');
INSERT INTO "event" VALUES(214,4,'showing','trial/6/second','2031-07-23T16:53:47.914Z',430782000000,'{"showing":49,"presentation":1}');
INSERT INTO "event" VALUES(215,4,'shown','trial/6/second','2031-07-23T16:53:49.927Z',432795000000,'{"showing":49,"complete":true}');
INSERT INTO "event" VALUES(216,4,'answer','trial/6/preference_or_tie/better','2031-07-23T16:53:53.953Z',434808000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(217,4,'answer','trial/6/comments/comments','2031-07-23T16:53:57.979Z',436821000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(218,4,'answer','trial/6/misc/misc','2031-07-23T16:54:02.005Z',438834000000,'{"value":7.0,"revision":1}');
INSERT INTO "event" VALUES(219,4,'answer','after/nasa_tlx/mental','2031-07-23T16:54:06.031Z',440847000000,'{"value":70.0,"revision":1}');
INSERT INTO "event" VALUES(220,4,'answer','after/nasa_tlx/physical','2031-07-23T16:54:10.057Z',442860000000,'{"value":75.0,"revision":1}');
INSERT INTO "event" VALUES(221,4,'answer','after/nasa_tlx/temporal','2031-07-23T16:54:14.083Z',444873000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(222,4,'answer','after/nasa_tlx/performance','2031-07-23T16:54:18.109Z',446886000000,'{"value":10.0,"revision":1}');
INSERT INTO "event" VALUES(223,4,'answer','after/nasa_tlx/effort','2031-07-23T16:54:22.135Z',448899000000,'{"value":45.0,"revision":1}');
INSERT INTO "event" VALUES(224,4,'answer','after/nasa_tlx/frustration','2031-07-23T16:54:26.161Z',450912000000,'{"value":40.0,"revision":1}');
INSERT INTO "event" VALUES(225,4,'remark','trial/1','2031-07-23T16:54:28.174Z',452925000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(226,4,'end','','2031-07-23T16:54:30.187Z',454938000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(227,5,'begin','','2031-07-23T16:54:36.226Z',456951000000,'{"part":"main","row":0,"plan_text_changed":false}');
INSERT INTO "event" VALUES(228,5,'answer','before/demographics/age','2031-07-23T16:54:40.252Z',458964000000,'{"value":77.0,"revision":1}');
INSERT INTO "event" VALUES(229,5,'answer','before/demographics/gender','2031-07-23T16:54:44.278Z',460977000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(230,5,'answer','before/demographics/vision','2031-07-23T16:54:48.304Z',462990000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(231,5,'answer','before/demographics/headsets','2031-07-23T16:54:52.330Z',465003000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(232,5,'showing','trial/1/first','2031-07-23T16:54:56.356Z',467016000000,'{"showing":50,"presentation":1}');
INSERT INTO "event" VALUES(233,5,'shown','trial/1/first','2031-07-23T16:54:58.369Z',469029000000,'{"showing":50,"complete":true}');
INSERT INTO "event" VALUES(234,5,'showing','trial/1/second','2031-07-23T16:55:02.395Z',471042000000,'{"showing":51,"presentation":1}');
INSERT INTO "event" VALUES(235,5,'shown','trial/1/second','2031-07-23T16:55:04.408Z',473055000000,'{"showing":51,"complete":true}');
INSERT INTO "event" VALUES(236,5,'answer','trial/1/preference_or_tie/better','2031-07-23T16:55:08.434Z',475068000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(237,5,'answer','trial/1/preference_or_tie/better','2031-07-23T16:55:12.460Z',477081000000,'{"value":3.0,"revision":2}');
INSERT INTO "event" VALUES(238,5,'answer','trial/1/comments/comments','2031-07-23T16:55:16.486Z',479094000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(239,5,'answer','trial/1/misc/misc','2031-07-23T16:55:20.512Z',481107000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(240,5,'showing','trial/2/first','2031-07-23T16:55:24.538Z',483120000000,'{"showing":52,"presentation":1}');
INSERT INTO "event" VALUES(241,5,'shown','trial/2/first','2031-07-23T16:55:26.551Z',485133000000,'{"showing":52,"complete":true}');
INSERT INTO "event" VALUES(242,5,'showing','trial/2/second','2031-07-23T16:55:30.577Z',487146000000,'{"showing":53,"presentation":1}');
INSERT INTO "event" VALUES(243,5,'shown','trial/2/second','2031-07-23T16:55:32.590Z',489159000000,'{"showing":53,"complete":true}');
INSERT INTO "event" VALUES(244,5,'answer','trial/2/preference_or_tie/better','2031-07-23T16:55:36.616Z',491172000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(245,5,'answer','trial/2/comments/comments','2031-07-23T16:55:40.642Z',493185000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(246,5,'answer','trial/2/misc/misc','2031-07-23T16:55:44.668Z',495198000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(247,5,'showing','trial/3/first','2031-07-23T16:55:48.694Z',497211000000,'{"showing":54,"presentation":1}');
INSERT INTO "event" VALUES(248,5,'shown','trial/3/first','2031-07-23T16:55:50.707Z',499224000000,'{"showing":54,"complete":true}');
INSERT INTO "event" VALUES(249,5,'showing','trial/3/second','2031-07-23T16:55:54.733Z',501237000000,'{"showing":55,"presentation":1}');
INSERT INTO "event" VALUES(250,5,'shown','trial/3/second','2031-07-23T16:55:56.746Z',503250000000,'{"showing":55,"complete":true}');
INSERT INTO "event" VALUES(251,5,'answer','trial/3/preference_or_tie/better','2031-07-23T16:56:00.772Z',505263000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(252,5,'answer','trial/3/comments/comments','2031-07-23T16:56:04.798Z',507276000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(253,5,'answer','trial/3/misc/misc','2031-07-23T16:56:08.824Z',509289000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(254,5,'showing','trial/4/first','2031-07-23T16:56:12.850Z',511302000000,'{"showing":56,"presentation":1}');
INSERT INTO "event" VALUES(255,5,'shown','trial/4/first','2031-07-23T16:56:14.863Z',513315000000,'{"showing":56,"complete":true}');
INSERT INTO "event" VALUES(256,5,'showing','trial/4/second','2031-07-23T16:56:18.889Z',515328000000,'{"showing":57,"presentation":1}');
INSERT INTO "event" VALUES(257,5,'shown','trial/4/second','2031-07-23T16:56:20.902Z',517341000000,'{"showing":57,"complete":true}');
INSERT INTO "event" VALUES(258,5,'answer','trial/4/preference_or_tie/better','2031-07-23T16:56:24.928Z',519354000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(259,5,'answer','trial/4/comments/comments','2031-07-23T16:56:28.954Z',521367000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(260,5,'answer','trial/4/misc/misc','2031-07-23T16:56:32.980Z',523380000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(261,5,'showing','trial/5/first','2031-07-23T16:56:37.006Z',525393000000,'{"showing":58,"presentation":1}');
INSERT INTO "event" VALUES(262,5,'shown','trial/5/first','2031-07-23T16:56:39.019Z',527406000000,'{"showing":58,"complete":true}');
INSERT INTO "event" VALUES(263,5,'showing','trial/5/second','2031-07-23T16:56:43.045Z',529419000000,'{"showing":59,"presentation":1}');
INSERT INTO "event" VALUES(264,5,'shown','trial/5/second','2031-07-23T16:56:45.058Z',531432000000,'{"showing":59,"complete":true}');
INSERT INTO "event" VALUES(265,5,'answer','trial/5/preference_or_tie/better','2031-07-23T16:56:49.084Z',533445000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(266,5,'answer','trial/5/comments/comments','2031-07-23T16:56:53.110Z',535458000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(267,5,'answer','trial/5/misc/misc','2031-07-23T16:56:57.136Z',537471000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(268,5,'showing','trial/6/first','2031-07-23T16:57:01.162Z',539484000000,'{"showing":60,"presentation":1}');
INSERT INTO "event" VALUES(269,5,'shown','trial/6/first','2031-07-23T16:57:03.175Z',541497000000,'{"showing":60,"complete":true}');
INSERT INTO "event" VALUES(270,5,'showing','trial/6/second','2031-07-23T16:57:07.201Z',543510000000,'{"showing":61,"presentation":1}');
INSERT INTO "event" VALUES(271,5,'shown','trial/6/second','2031-07-23T16:57:09.214Z',545523000000,'{"showing":61,"complete":true}');
INSERT INTO "event" VALUES(272,5,'answer','trial/6/preference_or_tie/better','2031-07-23T16:57:13.240Z',547536000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(273,5,'answer','trial/6/comments/comments','2031-07-23T16:57:17.266Z',549549000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(274,5,'answer','trial/6/misc/misc','2031-07-23T16:57:21.292Z',551562000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(275,5,'answer','after/nasa_tlx/mental','2031-07-23T16:57:25.318Z',553575000000,'{"value":70.0,"revision":1}');
INSERT INTO "event" VALUES(276,5,'answer','after/nasa_tlx/physical','2031-07-23T16:57:29.344Z',555588000000,'{"value":90.0,"revision":1}');
INSERT INTO "event" VALUES(277,5,'answer','after/nasa_tlx/temporal','2031-07-23T16:57:33.370Z',557601000000,'{"value":20.0,"revision":1}');
INSERT INTO "event" VALUES(278,5,'answer','after/nasa_tlx/performance','2031-07-23T16:57:37.396Z',559614000000,'{"value":55.0,"revision":1}');
INSERT INTO "event" VALUES(279,5,'answer','after/nasa_tlx/effort','2031-07-23T16:57:41.422Z',561627000000,'{"value":35.0,"revision":1}');
INSERT INTO "event" VALUES(280,5,'answer','after/nasa_tlx/frustration','2031-07-23T16:57:45.448Z',563640000000,'{"value":90.0,"revision":1}');
INSERT INTO "event" VALUES(281,5,'remark','trial/1','2031-07-23T16:57:47.461Z',565653000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(282,5,'end','','2031-07-23T16:57:49.474Z',567666000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(283,6,'begin','','2031-07-23T16:57:55.513Z',569679000000,'{"part":"main","row":1,"plan_text_changed":false}');
INSERT INTO "event" VALUES(284,6,'answer','before/demographics/age','2031-07-23T16:57:59.539Z',571692000000,'{"value":72.0,"revision":1}');
INSERT INTO "event" VALUES(285,6,'answer','before/demographics/gender','2031-07-23T16:58:03.565Z',573705000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(286,6,'answer','before/demographics/vision','2031-07-23T16:58:07.591Z',575718000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(287,6,'answer','before/demographics/headsets','2031-07-23T16:58:11.617Z',577731000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(288,6,'showing','trial/1/first','2031-07-23T16:58:15.643Z',579744000000,'{"showing":62,"presentation":1}');
INSERT INTO "event" VALUES(289,6,'shown','trial/1/first','2031-07-23T16:58:17.656Z',581757000000,'{"showing":62,"complete":true}');
INSERT INTO "event" VALUES(290,6,'showing','trial/1/second','2031-07-23T16:58:21.682Z',583770000000,'{"showing":63,"presentation":1}');
INSERT INTO "event" VALUES(291,6,'shown','trial/1/second','2031-07-23T16:58:23.695Z',585783000000,'{"showing":63,"complete":true}');
INSERT INTO "event" VALUES(292,6,'answer','trial/1/preference_or_tie/better','2031-07-23T16:58:27.721Z',587796000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(293,6,'answer','trial/1/preference_or_tie/better','2031-07-23T16:58:31.747Z',589809000000,'{"value":2.0,"revision":2}');
INSERT INTO "event" VALUES(294,6,'answer','trial/1/comments/comments','2031-07-23T16:58:35.773Z',591822000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(295,6,'answer','trial/1/misc/misc','2031-07-23T16:58:39.799Z',593835000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(296,6,'showing','trial/2/first','2031-07-23T16:58:43.825Z',595848000000,'{"showing":64,"presentation":1}');
INSERT INTO "event" VALUES(297,6,'shown','trial/2/first','2031-07-23T16:58:45.838Z',597861000000,'{"showing":64,"complete":true}');
INSERT INTO "event" VALUES(298,6,'showing','trial/2/second','2031-07-23T16:58:49.864Z',599874000000,'{"showing":65,"presentation":1}');
INSERT INTO "event" VALUES(299,6,'shown','trial/2/second','2031-07-23T16:58:51.877Z',601887000000,'{"showing":65,"complete":true}');
INSERT INTO "event" VALUES(300,6,'answer','trial/2/preference_or_tie/better','2031-07-23T16:58:55.903Z',603900000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(301,6,'answer','trial/2/comments/comments','2031-07-23T16:58:59.929Z',605913000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(302,6,'answer','trial/2/misc/misc','2031-07-23T16:59:03.955Z',607926000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(303,6,'showing','trial/3/first','2031-07-23T16:59:07.981Z',609939000000,'{"showing":66,"presentation":1}');
INSERT INTO "event" VALUES(304,6,'shown','trial/3/first','2031-07-23T16:59:09.994Z',611952000000,'{"showing":66,"complete":true}');
INSERT INTO "event" VALUES(305,6,'showing','trial/3/second','2031-07-23T16:59:14.020Z',613965000000,'{"showing":67,"presentation":1}');
INSERT INTO "event" VALUES(306,6,'shown','trial/3/second','2031-07-23T16:59:16.033Z',615978000000,'{"showing":67,"complete":true}');
INSERT INTO "event" VALUES(307,6,'answer','trial/3/preference_or_tie/better','2031-07-23T16:59:20.059Z',617991000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(308,6,'answer','trial/3/comments/comments','2031-07-23T16:59:24.085Z',620004000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(309,6,'answer','trial/3/misc/misc','2031-07-23T16:59:28.111Z',622017000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(310,6,'showing','trial/4/first','2031-07-23T16:59:32.137Z',624030000000,'{"showing":68,"presentation":1}');
INSERT INTO "event" VALUES(311,6,'shown','trial/4/first','2031-07-23T16:59:34.150Z',626043000000,'{"showing":68,"complete":true}');
INSERT INTO "event" VALUES(312,6,'showing','trial/4/second','2031-07-23T16:59:38.176Z',628056000000,'{"showing":69,"presentation":1}');
INSERT INTO "event" VALUES(313,6,'shown','trial/4/second','2031-07-23T16:59:40.189Z',630069000000,'{"showing":69,"complete":true}');
INSERT INTO "event" VALUES(314,6,'answer','trial/4/preference_or_tie/better','2031-07-23T16:59:44.215Z',632082000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(315,6,'answer','trial/4/comments/comments','2031-07-23T16:59:48.241Z',634095000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(316,6,'answer','trial/4/misc/misc','2031-07-23T16:59:52.267Z',636108000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(317,6,'showing','trial/5/first','2031-07-23T16:59:56.293Z',638121000000,'{"showing":70,"presentation":1}');
INSERT INTO "event" VALUES(318,6,'shown','trial/5/first','2031-07-23T16:59:58.306Z',640134000000,'{"showing":70,"complete":true}');
INSERT INTO "event" VALUES(319,6,'showing','trial/5/second','2031-07-23T17:00:02.332Z',642147000000,'{"showing":71,"presentation":1}');
INSERT INTO "event" VALUES(320,6,'shown','trial/5/second','2031-07-23T17:00:04.345Z',644160000000,'{"showing":71,"complete":true}');
INSERT INTO "event" VALUES(321,6,'answer','trial/5/preference_or_tie/better','2031-07-23T17:00:08.371Z',646173000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(322,6,'answer','trial/5/comments/comments','2031-07-23T17:00:12.397Z',648186000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(323,6,'answer','trial/5/misc/misc','2031-07-23T17:00:16.423Z',650199000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(324,6,'showing','trial/6/first','2031-07-23T17:00:20.449Z',652212000000,'{"showing":72,"presentation":1}');
INSERT INTO "event" VALUES(325,6,'shown','trial/6/first','2031-07-23T17:00:22.462Z',654225000000,'{"showing":72,"complete":true}');
INSERT INTO "event" VALUES(326,6,'showing','trial/6/second','2031-07-23T17:00:26.488Z',656238000000,'{"showing":73,"presentation":1}');
INSERT INTO "event" VALUES(327,6,'shown','trial/6/second','2031-07-23T17:00:28.501Z',658251000000,'{"showing":73,"complete":true}');
INSERT INTO "event" VALUES(328,6,'answer','trial/6/preference_or_tie/better','2031-07-23T17:00:32.527Z',660264000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(329,6,'answer','trial/6/comments/comments','2031-07-23T17:00:36.553Z',662277000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(330,6,'answer','trial/6/misc/misc','2031-07-23T17:00:40.579Z',664290000000,'{"value":7.0,"revision":1}');
INSERT INTO "event" VALUES(331,6,'answer','after/nasa_tlx/mental','2031-07-23T17:00:44.605Z',666303000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(332,6,'answer','after/nasa_tlx/physical','2031-07-23T17:00:48.631Z',668316000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(333,6,'answer','after/nasa_tlx/temporal','2031-07-23T17:00:52.657Z',670329000000,'{"value":15.0,"revision":1}');
INSERT INTO "event" VALUES(334,6,'answer','after/nasa_tlx/performance','2031-07-23T17:00:56.683Z',672342000000,'{"value":100.0,"revision":1}');
INSERT INTO "event" VALUES(335,6,'answer','after/nasa_tlx/effort','2031-07-23T17:01:00.709Z',674355000000,'{"value":20.0,"revision":1}');
INSERT INTO "event" VALUES(336,6,'answer','after/nasa_tlx/frustration','2031-07-23T17:01:04.735Z',676368000000,'{"value":65.0,"revision":1}');
INSERT INTO "event" VALUES(337,6,'remark','trial/1','2031-07-23T17:01:06.748Z',678381000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(338,6,'end','','2031-07-23T17:01:08.761Z',680394000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(339,7,'begin','','2031-07-23T17:01:14.800Z',682407000000,'{"part":"main","row":6,"plan_text_changed":false}');
INSERT INTO "event" VALUES(340,7,'answer','before/demographics/age','2031-07-23T17:01:18.826Z',684420000000,'{"value":53.0,"revision":1}');
INSERT INTO "event" VALUES(341,7,'answer','before/demographics/gender','2031-07-23T17:01:22.852Z',686433000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(342,7,'answer','before/demographics/vision','2031-07-23T17:01:26.878Z',688446000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(343,7,'answer','before/demographics/headsets','2031-07-23T17:01:30.904Z',690459000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(344,7,'showing','trial/1/first','2031-07-23T17:01:34.930Z',692472000000,'{"showing":74,"presentation":1}');
INSERT INTO "event" VALUES(345,7,'shown','trial/1/first','2031-07-23T17:01:36.943Z',694485000000,'{"showing":74,"complete":true}');
INSERT INTO "event" VALUES(346,7,'showing','trial/1/second','2031-07-23T17:01:40.969Z',696498000000,'{"showing":75,"presentation":1}');
INSERT INTO "event" VALUES(347,7,'shown','trial/1/second','2031-07-23T17:01:42.982Z',698511000000,'{"showing":75,"complete":true}');
INSERT INTO "event" VALUES(348,7,'answer','trial/1/preference_or_tie/better','2031-07-23T17:01:47.008Z',700524000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(349,7,'answer','trial/1/preference_or_tie/better','2031-07-23T17:01:51.034Z',702537000000,'{"value":3.0,"revision":2}');
INSERT INTO "event" VALUES(350,7,'answer','trial/1/comments/comments','2031-07-23T17:01:55.060Z',704550000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(351,7,'answer','trial/1/misc/misc','2031-07-23T17:01:59.086Z',706563000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(352,7,'showing','trial/2/first','2031-07-23T17:02:03.112Z',708576000000,'{"showing":76,"presentation":1}');
INSERT INTO "event" VALUES(353,7,'shown','trial/2/first','2031-07-23T17:02:05.125Z',710589000000,'{"showing":76,"complete":true}');
INSERT INTO "event" VALUES(354,7,'showing','trial/2/second','2031-07-23T17:02:09.151Z',712602000000,'{"showing":77,"presentation":1}');
INSERT INTO "event" VALUES(355,7,'shown','trial/2/second','2031-07-23T17:02:11.164Z',714615000000,'{"showing":77,"complete":true}');
INSERT INTO "event" VALUES(356,7,'answer','trial/2/preference_or_tie/better','2031-07-23T17:02:15.190Z',716628000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(357,7,'answer','trial/2/comments/comments','2031-07-23T17:02:19.216Z',718641000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(358,7,'answer','trial/2/misc/misc','2031-07-23T17:02:23.242Z',720654000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(359,7,'showing','trial/3/first','2031-07-23T17:02:27.268Z',722667000000,'{"showing":78,"presentation":1}');
INSERT INTO "event" VALUES(360,7,'shown','trial/3/first','2031-07-23T17:02:29.281Z',724680000000,'{"showing":78,"complete":true}');
INSERT INTO "event" VALUES(361,7,'showing','trial/3/second','2031-07-23T17:02:33.307Z',726693000000,'{"showing":79,"presentation":1}');
INSERT INTO "event" VALUES(362,7,'shown','trial/3/second','2031-07-23T17:02:35.320Z',728706000000,'{"showing":79,"complete":true}');
INSERT INTO "event" VALUES(363,7,'answer','trial/3/preference_or_tie/better','2031-07-23T17:02:39.346Z',730719000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(364,7,'answer','trial/3/comments/comments','2031-07-23T17:02:43.372Z',732732000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(365,7,'answer','trial/3/misc/misc','2031-07-23T17:02:47.398Z',734745000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(366,7,'showing','trial/4/first','2031-07-23T17:02:51.424Z',736758000000,'{"showing":80,"presentation":1}');
INSERT INTO "event" VALUES(367,7,'shown','trial/4/first','2031-07-23T17:02:53.437Z',738771000000,'{"showing":80,"complete":true}');
INSERT INTO "event" VALUES(368,7,'showing','trial/4/second','2031-07-23T17:02:57.463Z',740784000000,'{"showing":81,"presentation":1}');
INSERT INTO "event" VALUES(369,7,'shown','trial/4/second','2031-07-23T17:02:59.476Z',742797000000,'{"showing":81,"complete":true}');
INSERT INTO "event" VALUES(370,7,'answer','trial/4/preference_or_tie/better','2031-07-23T17:03:03.502Z',744810000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(371,7,'answer','trial/4/comments/comments','2031-07-23T17:03:07.528Z',746823000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(372,7,'answer','trial/4/misc/misc','2031-07-23T17:03:11.554Z',748836000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(373,7,'showing','trial/5/first','2031-07-23T17:03:15.580Z',750849000000,'{"showing":82,"presentation":1}');
INSERT INTO "event" VALUES(374,7,'shown','trial/5/first','2031-07-23T17:03:17.593Z',752862000000,'{"showing":82,"complete":true}');
INSERT INTO "event" VALUES(375,7,'showing','trial/5/second','2031-07-23T17:03:21.619Z',754875000000,'{"showing":83,"presentation":1}');
INSERT INTO "event" VALUES(376,7,'shown','trial/5/second','2031-07-23T17:03:23.632Z',756888000000,'{"showing":83,"complete":true}');
INSERT INTO "event" VALUES(377,7,'answer','trial/5/preference_or_tie/better','2031-07-23T17:03:27.658Z',758901000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(378,7,'answer','trial/5/comments/comments','2031-07-23T17:03:31.684Z',760914000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(379,7,'answer','trial/5/misc/misc','2031-07-23T17:03:35.710Z',762927000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(380,7,'showing','trial/6/first','2031-07-23T17:03:39.736Z',764940000000,'{"showing":84,"presentation":1}');
INSERT INTO "event" VALUES(381,7,'shown','trial/6/first','2031-07-23T17:03:41.749Z',766953000000,'{"showing":84,"complete":true}');
INSERT INTO "event" VALUES(382,7,'showing','trial/6/second','2031-07-23T17:03:45.775Z',768966000000,'{"showing":85,"presentation":1}');
INSERT INTO "event" VALUES(383,7,'shown','trial/6/second','2031-07-23T17:03:47.788Z',770979000000,'{"showing":85,"complete":true}');
INSERT INTO "event" VALUES(384,7,'answer','trial/6/preference_or_tie/better','2031-07-23T17:03:51.814Z',772992000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(385,7,'answer','trial/6/comments/comments','2031-07-23T17:03:55.840Z',775005000000,'{"value":null,"revision":1,"text":"=1+1, näïve\twords"}');
INSERT INTO "event" VALUES(386,7,'answer','trial/6/misc/misc','2031-07-23T17:03:59.866Z',777018000000,'{"value":6.0,"revision":1}');
INSERT INTO "event" VALUES(387,7,'answer','after/nasa_tlx/mental','2031-07-23T17:04:03.892Z',779031000000,'{"value":70.0,"revision":1}');
INSERT INTO "event" VALUES(388,7,'answer','after/nasa_tlx/physical','2031-07-23T17:04:07.918Z',781044000000,'{"value":70.0,"revision":1}');
INSERT INTO "event" VALUES(389,7,'answer','after/nasa_tlx/temporal','2031-07-23T17:04:11.944Z',783057000000,'{"value":45.0,"revision":1}');
INSERT INTO "event" VALUES(390,7,'answer','after/nasa_tlx/performance','2031-07-23T17:04:15.970Z',785070000000,'{"value":10.0,"revision":1}');
INSERT INTO "event" VALUES(391,7,'answer','after/nasa_tlx/effort','2031-07-23T17:04:19.996Z',787083000000,'{"value":60.0,"revision":1}');
INSERT INTO "event" VALUES(392,7,'answer','after/nasa_tlx/frustration','2031-07-23T17:04:24.022Z',789096000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(393,7,'remark','trial/1','2031-07-23T17:04:26.035Z',791109000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(394,7,'end','','2031-07-23T17:04:28.048Z',793122000000,'{"status":"complete","why":""}');
CREATE TABLE participant (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE COLLATE NOCASE,
  sub TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('person', 'pilot', 'simulated')),
  withdrawing INTEGER NOT NULL DEFAULT 0
) STRICT;
INSERT INTO "participant" VALUES(1,'P0','ccqqp7no0qju','person',0);
INSERT INTO "participant" VALUES(2,'P1','duhzc5yf1nkv','person',0);
INSERT INTO "participant" VALUES(3,'P2','s4u07nrvz5er','person',0);
INSERT INTO "participant" VALUES(4,'P3','mczirdk34zyn','person',0);
INSERT INTO "participant" VALUES(5,'P4','ankaqhzyo9dm','person',0);
INSERT INTO "participant" VALUES(6,'P5','kv9472bfch59','person',0);
INSERT INTO "participant" VALUES(7,'P6','qicxf7atwef8','person',0);
CREATE TABLE plan (id INTEGER PRIMARY KEY, text TEXT NOT NULL, meaning TEXT NOT NULL, UNIQUE (text, meaning)) STRICT;
INSERT INTO "plan" VALUES(1,'schema = 1
name = "pairs"
title = "Which one?"
seed = 9
[common]
scene = "planes"
size = "48x40"
[trial]
seconds = 1
shows = "pair"
repeats = 2
scales = ["preference_or_tie", "comments"]
[sickness]
scale = "misc"
stop_at = 6
[questionnaires]
before = ["demographics"]
after = ["nasa_tlx"]
[[condition]]
name = "late"
latency = 400
warp = "none"
[[condition]]
name = "rotation"
latency = 400
warp = "rotation"
[[condition]]
name = "reference"
latency = 0
warp = "none"
reference = true
[[family]]
name = "help"
compare = [{ better = "rotation", baseline = "late" }, { better = "reference", baseline = "late" }]
','{"conditions":[{"name":"late","settings":{"latency":400,"scene":"planes","size":"48x40","warp":"none"},"reference":false},{"name":"rotation","settings":{"latency":400,"scene":"planes","size":"48x40","warp":"rotation"},"reference":false},{"name":"reference","settings":{"latency":0,"scene":"planes","size":"48x40","warp":"none"},"reference":true}],"seconds":1.0,"repeats":2,"order":"williams","seed":9,"scales":[{"name":"preference_or_tie","asked":["",["better","Which of the two was better?","choice",["the first","the second","no difference"],0.0,0.0,1.0]],"range":[0.0,0.0,1.0],"anchors":{},"low_is_good":false},{"name":"comments","asked":["",["comments","What did you notice, and what disturbed you?","text",[],0.0,0.0,1.0]],"range":[0.0,0.0,1.0],"anchors":{},"low_is_good":false}],"practice":null,"sickness":{"scale":{"name":"misc","asked":["",["misc","How do you feel now? Symptoms: dizziness, warmth, headache, stomach awareness, sweating."]],"range":[0.0,10.0,1.0],"anchors":{"0":"no problems","1":"uneasiness, no typical symptoms","2":"symptoms, vague","3":"symptoms, slight","4":"symptoms, fairly strong","5":"symptoms, severe","6":"nausea, slight","7":"nausea, fairly strong","8":"nausea, severe","9":"nausea, (near) retching","10":"vomiting"},"low_is_good":true},"every":1,"stop_at":6.0,"rise":null},"before":[{"name":"demographics","asked":["",["age","How old are you, in years?","number",[],16.0,99.0,1.0],["gender","What is your gender?","choice",["female","male","another","I prefer not to say"],0.0,0.0,1.0],["vision","How do you see right now?","choice",["well, without glasses","well, with glasses or lenses","not well"],0.0,0.0,1.0],["headsets","How often do you use a VR headset?","choice",["never before","a few times so far","every month","every week"],0.0,0.0,1.0]],"range":[0.0,0.0,1.0],"anchors":{},"low_is_good":false}],"after":[{"name":"nasa_tlx","asked":["",["mental","How mentally demanding was the task?"],["physical","How physically demanding was the task?"],["temporal","How hurried or rushed was the pace of the task?"],["performance","How successful were you in accomplishing what you were asked to do?"],["effort","How hard did you have to work to accomplish your level of performance?"],["frustration","How insecure, discouraged, irritated, stressed, and annoyed were you?"]],"range":[0.0,100.0,5.0],"anchors":{"0":"very low, or perfect","100":"very high, or failure"},"low_is_good":true}],"shows":"pair"}');
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
INSERT INTO "session" VALUES(1,1,1,'main',10,'[["reference/rotation","late/reference","rotation/late"],["reference/late","late/rotation","rotation/reference"]]',1,'complete','','2031-07-23T16:41:11.026Z','2031-07-23T16:44:28.300Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(2,2,1,'main',5,'[["late/rotation","rotation/reference","reference/late"],["reference/rotation","late/reference","rotation/late"]]',1,'complete','','2031-07-23T16:44:30.313Z','2031-07-23T16:47:47.587Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(3,3,1,'main',8,'[["late/reference","reference/rotation","rotation/late"],["rotation/reference","late/rotation","reference/late"]]',1,'complete','','2031-07-23T16:47:49.600Z','2031-07-23T16:51:06.874Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-P2.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(4,4,1,'main',11,'[["rotation/late","reference/rotation","late/reference"],["rotation/reference","reference/late","late/rotation"]]',1,'complete','','2031-07-23T16:51:08.887Z','2031-07-23T16:54:32.200Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(5,5,1,'main',0,'[["rotation/reference","late/rotation","reference/late"],["rotation/late","late/reference","reference/rotation"]]',1,'complete','','2031-07-23T16:54:34.213Z','2031-07-23T16:57:51.487Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(6,6,1,'main',1,'[["late/rotation","reference/late","rotation/reference"],["late/reference","reference/rotation","rotation/late"]]',1,'complete','','2031-07-23T16:57:53.500Z','2031-07-23T17:01:10.774Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-P5.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(7,7,1,'main',6,'[["reference/rotation","rotation/late","late/reference"],["late/rotation","reference/late","rotation/reference"]]',1,'complete','','2031-07-23T17:01:12.787Z','2031-07-23T17:04:30.061Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
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
INSERT INTO "showing" VALUES(1,1,'trial/1/first',1,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ccqqp7no0qju_ses-1_trial-1-first_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:31.156Z');
INSERT INTO "showing" VALUES(2,1,'trial/1/second',1,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ccqqp7no0qju_ses-1_trial-1-second_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:37.195Z');
INSERT INTO "showing" VALUES(3,1,'trial/2/first',2,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ccqqp7no0qju_ses-1_trial-2-first_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:59.338Z');
INSERT INTO "showing" VALUES(4,1,'trial/2/second',2,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ccqqp7no0qju_ses-1_trial-2-second_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:05.377Z');
INSERT INTO "showing" VALUES(5,1,'trial/3/first',3,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ccqqp7no0qju_ses-1_trial-3-first_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:23.494Z');
INSERT INTO "showing" VALUES(6,1,'trial/3/second',3,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ccqqp7no0qju_ses-1_trial-3-second_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:29.533Z');
INSERT INTO "showing" VALUES(7,1,'trial/4/first',4,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ccqqp7no0qju_ses-1_trial-4-first_1.csv','{"latency_ms_median":429.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":26.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:47.650Z');
INSERT INTO "showing" VALUES(8,1,'trial/4/second',4,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ccqqp7no0qju_ses-1_trial-4-second_1.csv','{"latency_ms_median":429.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":26.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:53.689Z');
INSERT INTO "showing" VALUES(9,1,'trial/5/first',5,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ccqqp7no0qju_ses-1_trial-5-first_1.csv','{"latency_ms_median":436.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":25.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:43:11.806Z');
INSERT INTO "showing" VALUES(10,1,'trial/5/second',5,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ccqqp7no0qju_ses-1_trial-5-second_1.csv','{"latency_ms_median":436.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":25.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:43:17.845Z');
INSERT INTO "showing" VALUES(11,1,'trial/6/first',6,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ccqqp7no0qju_ses-1_trial-6-first_1.csv','{"latency_ms_median":443.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":24.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:43:35.962Z');
INSERT INTO "showing" VALUES(12,1,'trial/6/second',6,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ccqqp7no0qju_ses-1_trial-6-second_1.csv','{"latency_ms_median":443.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":24.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:43:42.001Z');
INSERT INTO "showing" VALUES(13,2,'trial/1/first',1,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-1-first_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:44:50.443Z');
INSERT INTO "showing" VALUES(14,2,'trial/1/second',1,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','duhzc5yf1nkv_ses-1_trial-1-second_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:44:56.482Z');
INSERT INTO "showing" VALUES(15,2,'trial/2/first',2,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','duhzc5yf1nkv_ses-1_trial-2-first_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:18.625Z');
INSERT INTO "showing" VALUES(16,2,'trial/2/second',2,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-2-second_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:24.664Z');
INSERT INTO "showing" VALUES(17,2,'trial/3/first',3,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-3-first_1.csv','{"latency_ms_median":423.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:42.781Z');
INSERT INTO "showing" VALUES(18,2,'trial/3/second',3,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-3-second_1.csv','{"latency_ms_median":423.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:48.820Z');
INSERT INTO "showing" VALUES(19,2,'trial/4/first',4,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-4-first_1.csv','{"latency_ms_median":430.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:06.937Z');
INSERT INTO "showing" VALUES(20,2,'trial/4/second',4,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','duhzc5yf1nkv_ses-1_trial-4-second_1.csv','{"latency_ms_median":430.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:12.976Z');
INSERT INTO "showing" VALUES(21,2,'trial/5/first',5,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-5-first_1.csv','{"latency_ms_median":437.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:31.093Z');
INSERT INTO "showing" VALUES(22,2,'trial/5/second',5,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-5-second_1.csv','{"latency_ms_median":437.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:37.132Z');
INSERT INTO "showing" VALUES(23,2,'trial/6/first',6,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','duhzc5yf1nkv_ses-1_trial-6-first_1.csv','{"latency_ms_median":444.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:55.249Z');
INSERT INTO "showing" VALUES(24,2,'trial/6/second',6,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','duhzc5yf1nkv_ses-1_trial-6-second_1.csv','{"latency_ms_median":444.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:47:01.288Z');
INSERT INTO "showing" VALUES(25,3,'trial/1/first',1,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','s4u07nrvz5er_ses-1_trial-1-first_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:09.730Z');
INSERT INTO "showing" VALUES(26,3,'trial/1/second',1,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','s4u07nrvz5er_ses-1_trial-1-second_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:15.769Z');
INSERT INTO "showing" VALUES(27,3,'trial/2/first',2,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','s4u07nrvz5er_ses-1_trial-2-first_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:37.912Z');
INSERT INTO "showing" VALUES(28,3,'trial/2/second',2,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','s4u07nrvz5er_ses-1_trial-2-second_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:43.951Z');
INSERT INTO "showing" VALUES(29,3,'trial/3/first',3,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','s4u07nrvz5er_ses-1_trial-3-first_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:02.068Z');
INSERT INTO "showing" VALUES(30,3,'trial/3/second',3,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','s4u07nrvz5er_ses-1_trial-3-second_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:08.107Z');
INSERT INTO "showing" VALUES(31,3,'trial/4/first',4,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','s4u07nrvz5er_ses-1_trial-4-first_1.csv','{"latency_ms_median":431.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:26.224Z');
INSERT INTO "showing" VALUES(32,3,'trial/4/second',4,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','s4u07nrvz5er_ses-1_trial-4-second_1.csv','{"latency_ms_median":431.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:32.263Z');
INSERT INTO "showing" VALUES(33,3,'trial/5/first',5,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','s4u07nrvz5er_ses-1_trial-5-first_1.csv','{"latency_ms_median":438.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:50.380Z');
INSERT INTO "showing" VALUES(34,3,'trial/5/second',5,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','s4u07nrvz5er_ses-1_trial-5-second_1.csv','{"latency_ms_median":438.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:56.419Z');
INSERT INTO "showing" VALUES(35,3,'trial/6/first',6,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','s4u07nrvz5er_ses-1_trial-6-first_1.csv','{"latency_ms_median":445.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:50:14.536Z');
INSERT INTO "showing" VALUES(36,3,'trial/6/second',6,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','s4u07nrvz5er_ses-1_trial-6-second_1.csv','{"latency_ms_median":445.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:50:20.575Z');
INSERT INTO "showing" VALUES(37,4,'trial/1/first',1,1,'rotation',1,0,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','mczirdk34zyn_ses-1_trial-1-first_1.csv','{}','{}','2031-07-23T16:51:29.017Z');
INSERT INTO "showing" VALUES(38,4,'trial/1/first',1,1,'rotation',2,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','mczirdk34zyn_ses-1_trial-1-first_2.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:51:35.056Z');
INSERT INTO "showing" VALUES(39,4,'trial/1/second',1,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','mczirdk34zyn_ses-1_trial-1-second_1.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:51:41.095Z');
INSERT INTO "showing" VALUES(40,4,'trial/2/first',2,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','mczirdk34zyn_ses-1_trial-2-first_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:03.238Z');
INSERT INTO "showing" VALUES(41,4,'trial/2/second',2,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','mczirdk34zyn_ses-1_trial-2-second_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:09.277Z');
INSERT INTO "showing" VALUES(42,4,'trial/3/first',3,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','mczirdk34zyn_ses-1_trial-3-first_1.csv','{"latency_ms_median":425.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:27.394Z');
INSERT INTO "showing" VALUES(43,4,'trial/3/second',3,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','mczirdk34zyn_ses-1_trial-3-second_1.csv','{"latency_ms_median":425.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:33.433Z');
INSERT INTO "showing" VALUES(44,4,'trial/4/first',4,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','mczirdk34zyn_ses-1_trial-4-first_1.csv','{"latency_ms_median":432.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:51.550Z');
INSERT INTO "showing" VALUES(45,4,'trial/4/second',4,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','mczirdk34zyn_ses-1_trial-4-second_1.csv','{"latency_ms_median":432.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:57.589Z');
INSERT INTO "showing" VALUES(46,4,'trial/5/first',5,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','mczirdk34zyn_ses-1_trial-5-first_1.csv','{"latency_ms_median":439.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:15.706Z');
INSERT INTO "showing" VALUES(47,4,'trial/5/second',5,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','mczirdk34zyn_ses-1_trial-5-second_1.csv','{"latency_ms_median":439.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:21.745Z');
INSERT INTO "showing" VALUES(48,4,'trial/6/first',6,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','mczirdk34zyn_ses-1_trial-6-first_1.csv','{"latency_ms_median":446.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:39.862Z');
INSERT INTO "showing" VALUES(49,4,'trial/6/second',6,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','mczirdk34zyn_ses-1_trial-6-second_1.csv','{"latency_ms_median":446.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:45.901Z');
INSERT INTO "showing" VALUES(50,5,'trial/1/first',1,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ankaqhzyo9dm_ses-1_trial-1-first_1.csv','{"latency_ms_median":412.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120","onset_s":13.5}','{"psnr_db":28.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:54:54.343Z');
INSERT INTO "showing" VALUES(51,5,'trial/1/second',1,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-1-second_1.csv','{"latency_ms_median":412.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120","onset_s":13.5}','{"psnr_db":28.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:00.382Z');
INSERT INTO "showing" VALUES(52,5,'trial/2/first',2,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-2-first_1.csv','{"latency_ms_median":419.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120","onset_s":14.5}','{"psnr_db":27.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:22.525Z');
INSERT INTO "showing" VALUES(53,5,'trial/2/second',2,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ankaqhzyo9dm_ses-1_trial-2-second_1.csv','{"latency_ms_median":419.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120","onset_s":14.5}','{"psnr_db":27.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:28.564Z');
INSERT INTO "showing" VALUES(54,5,'trial/3/first',3,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-3-first_1.csv','{"latency_ms_median":426.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120","onset_s":15.5}','{"psnr_db":26.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:46.681Z');
INSERT INTO "showing" VALUES(55,5,'trial/3/second',3,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-3-second_1.csv','{"latency_ms_median":426.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120","onset_s":15.5}','{"psnr_db":26.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:52.720Z');
INSERT INTO "showing" VALUES(56,5,'trial/4/first',4,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ankaqhzyo9dm_ses-1_trial-4-first_1.csv','{"latency_ms_median":433.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120","onset_s":16.5}','{"psnr_db":25.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:10.837Z');
INSERT INTO "showing" VALUES(57,5,'trial/4/second',4,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-4-second_1.csv','{"latency_ms_median":433.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120","onset_s":16.5}','{"psnr_db":25.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:16.876Z');
INSERT INTO "showing" VALUES(58,5,'trial/5/first',5,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-5-first_1.csv','{"latency_ms_median":440.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120","onset_s":17.5}','{"psnr_db":24.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:34.993Z');
INSERT INTO "showing" VALUES(59,5,'trial/5/second',5,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-5-second_1.csv','{"latency_ms_median":440.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120","onset_s":17.5}','{"psnr_db":24.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:41.032Z');
INSERT INTO "showing" VALUES(60,5,'trial/6/first',6,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','ankaqhzyo9dm_ses-1_trial-6-first_1.csv','{"latency_ms_median":447.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120","onset_s":18.5}','{"psnr_db":23.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:59.149Z');
INSERT INTO "showing" VALUES(61,5,'trial/6/second',6,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','ankaqhzyo9dm_ses-1_trial-6-second_1.csv','{"latency_ms_median":447.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120","onset_s":18.5}','{"psnr_db":23.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:57:05.188Z');
INSERT INTO "showing" VALUES(62,6,'trial/1/first',1,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','kv9472bfch59_ses-1_trial-1-first_1.csv','{"latency_ms_median":413.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:58:13.630Z');
INSERT INTO "showing" VALUES(63,6,'trial/1/second',1,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','kv9472bfch59_ses-1_trial-1-second_1.csv','{"latency_ms_median":413.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:58:19.669Z');
INSERT INTO "showing" VALUES(64,6,'trial/2/first',2,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','kv9472bfch59_ses-1_trial-2-first_1.csv','{"latency_ms_median":420.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:58:41.812Z');
INSERT INTO "showing" VALUES(65,6,'trial/2/second',2,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','kv9472bfch59_ses-1_trial-2-second_1.csv','{"latency_ms_median":420.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:58:47.851Z');
INSERT INTO "showing" VALUES(66,6,'trial/3/first',3,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','kv9472bfch59_ses-1_trial-3-first_1.csv','{"latency_ms_median":427.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:05.968Z');
INSERT INTO "showing" VALUES(67,6,'trial/3/second',3,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','kv9472bfch59_ses-1_trial-3-second_1.csv','{"latency_ms_median":427.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:12.007Z');
INSERT INTO "showing" VALUES(68,6,'trial/4/first',4,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','kv9472bfch59_ses-1_trial-4-first_1.csv','{"latency_ms_median":434.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:30.124Z');
INSERT INTO "showing" VALUES(69,6,'trial/4/second',4,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','kv9472bfch59_ses-1_trial-4-second_1.csv','{"latency_ms_median":434.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:36.163Z');
INSERT INTO "showing" VALUES(70,6,'trial/5/first',5,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','kv9472bfch59_ses-1_trial-5-first_1.csv','{"latency_ms_median":441.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:54.280Z');
INSERT INTO "showing" VALUES(71,6,'trial/5/second',5,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','kv9472bfch59_ses-1_trial-5-second_1.csv','{"latency_ms_median":441.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:00:00.319Z');
INSERT INTO "showing" VALUES(72,6,'trial/6/first',6,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','kv9472bfch59_ses-1_trial-6-first_1.csv','{"latency_ms_median":448.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:00:18.436Z');
INSERT INTO "showing" VALUES(73,6,'trial/6/second',6,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','kv9472bfch59_ses-1_trial-6-second_1.csv','{"latency_ms_median":448.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:00:24.475Z');
INSERT INTO "showing" VALUES(74,7,'trial/1/first',1,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','qicxf7atwef8_ses-1_trial-1-first_1.csv','{"latency_ms_median":414.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:01:32.917Z');
INSERT INTO "showing" VALUES(75,7,'trial/1/second',1,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','qicxf7atwef8_ses-1_trial-1-second_1.csv','{"latency_ms_median":414.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:01:38.956Z');
INSERT INTO "showing" VALUES(76,7,'trial/2/first',2,1,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','qicxf7atwef8_ses-1_trial-2-first_1.csv','{"latency_ms_median":421.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:01.099Z');
INSERT INTO "showing" VALUES(77,7,'trial/2/second',2,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','qicxf7atwef8_ses-1_trial-2-second_1.csv','{"latency_ms_median":421.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:07.138Z');
INSERT INTO "showing" VALUES(78,7,'trial/3/first',3,1,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','qicxf7atwef8_ses-1_trial-3-first_1.csv','{"latency_ms_median":428.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:25.255Z');
INSERT INTO "showing" VALUES(79,7,'trial/3/second',3,1,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','qicxf7atwef8_ses-1_trial-3-second_1.csv','{"latency_ms_median":428.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:31.294Z');
INSERT INTO "showing" VALUES(80,7,'trial/4/first',4,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','qicxf7atwef8_ses-1_trial-4-first_1.csv','{"latency_ms_median":435.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:49.411Z');
INSERT INTO "showing" VALUES(81,7,'trial/4/second',4,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','qicxf7atwef8_ses-1_trial-4-second_1.csv','{"latency_ms_median":435.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":25.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:55.450Z');
INSERT INTO "showing" VALUES(82,7,'trial/5/first',5,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','qicxf7atwef8_ses-1_trial-5-first_1.csv','{"latency_ms_median":442.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:03:13.567Z');
INSERT INTO "showing" VALUES(83,7,'trial/5/second',5,2,'late',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"none"}','qicxf7atwef8_ses-1_trial-5-second_1.csv','{"latency_ms_median":442.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":24.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:03:19.606Z');
INSERT INTO "showing" VALUES(84,7,'trial/6/first',6,2,'rotation',1,1,'{"scene":"planes","size":"48x40","latency":400,"warp":"rotation"}','qicxf7atwef8_ses-1_trial-6-first_1.csv','{"latency_ms_median":449.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:03:37.723Z');
INSERT INTO "showing" VALUES(85,7,'trial/6/second',6,2,'reference',1,1,'{"scene":"planes","size":"48x40","latency":0,"warp":"none"}','qicxf7atwef8_ses-1_trial-6-second_1.csv','{"latency_ms_median":449.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":23.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:03:43.762Z');
CREATE TABLE study (name TEXT NOT NULL, made_by TEXT NOT NULL) STRICT;
INSERT INTO "study" VALUES('pairs','0.2.0');
CREATE TABLE withdrawn (code TEXT NOT NULL PRIMARY KEY COLLATE NOCASE, cleaned INTEGER NOT NULL) STRICT;
CREATE INDEX event_of_session ON event (session, kind);
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('participant',7);
INSERT INTO "sqlite_sequence" VALUES('session',7);
INSERT INTO "sqlite_sequence" VALUES('event',394);
INSERT INTO "sqlite_sequence" VALUES('answer',203);
INSERT INTO "sqlite_sequence" VALUES('showing',85);
COMMIT;
