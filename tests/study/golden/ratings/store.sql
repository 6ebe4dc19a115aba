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
INSERT INTO "answer" VALUES(1,1,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:17.065Z',NULL);
INSERT INTO "answer" VALUES(2,1,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:21.091Z',NULL);
INSERT INTO "answer" VALUES(3,1,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:25.117Z',NULL);
INSERT INTO "answer" VALUES(4,1,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:29.143Z',NULL);
INSERT INTO "answer" VALUES(5,1,'before/vrsq/headache',1,'before',0,'vrsq','headache',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:33.169Z',NULL);
INSERT INTO "answer" VALUES(6,1,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:37.195Z',NULL);
INSERT INTO "answer" VALUES(7,1,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:41.221Z',NULL);
INSERT INTO "answer" VALUES(8,1,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:45.247Z',NULL);
INSERT INTO "answer" VALUES(9,1,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:49.273Z',NULL);
INSERT INTO "answer" VALUES(10,1,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:59.338Z',1);
INSERT INTO "answer" VALUES(11,1,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'experimenter','2031-07-23T16:42:09.403Z',2);
INSERT INTO "answer" VALUES(12,1,'trial/1/grade/grade',2,'trial',1,'grade','grade',5.5,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:13.429Z',2);
INSERT INTO "answer" VALUES(13,1,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:17.455Z',2);
INSERT INTO "answer" VALUES(14,1,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.5,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:27.520Z',3);
INSERT INTO "answer" VALUES(15,1,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:31.546Z',3);
INSERT INTO "answer" VALUES(16,1,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.5,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:43.624Z',4);
INSERT INTO "answer" VALUES(17,1,'trial/3/fms/fms',1,'trial',3,'fms','fms',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:47.650Z',4);
INSERT INTO "answer" VALUES(18,1,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:51.676Z',NULL);
INSERT INTO "answer" VALUES(19,1,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:55.702Z',NULL);
INSERT INTO "answer" VALUES(20,1,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:59.728Z',NULL);
INSERT INTO "answer" VALUES(21,1,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:03.754Z',NULL);
INSERT INTO "answer" VALUES(22,1,'after/vrsq/headache',1,'after',0,'vrsq','headache',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:07.780Z',NULL);
INSERT INTO "answer" VALUES(23,1,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:11.806Z',NULL);
INSERT INTO "answer" VALUES(24,1,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:15.832Z',NULL);
INSERT INTO "answer" VALUES(25,1,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:19.858Z',NULL);
INSERT INTO "answer" VALUES(26,1,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:23.884Z',NULL);
INSERT INTO "answer" VALUES(27,2,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:39.988Z',NULL);
INSERT INTO "answer" VALUES(28,2,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:44.014Z',NULL);
INSERT INTO "answer" VALUES(29,2,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:48.040Z',NULL);
INSERT INTO "answer" VALUES(30,2,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:52.066Z',NULL);
INSERT INTO "answer" VALUES(31,2,'before/vrsq/headache',1,'before',0,'vrsq','headache',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:56.092Z',NULL);
INSERT INTO "answer" VALUES(32,2,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:00.118Z',NULL);
INSERT INTO "answer" VALUES(33,2,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:04.144Z',NULL);
INSERT INTO "answer" VALUES(34,2,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:08.170Z',NULL);
INSERT INTO "answer" VALUES(35,2,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:12.196Z',NULL);
INSERT INTO "answer" VALUES(36,2,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:22.261Z',5);
INSERT INTO "answer" VALUES(37,2,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:44:32.326Z',6);
INSERT INTO "answer" VALUES(38,2,'trial/1/grade/grade',2,'trial',1,'grade','grade',1.5,2.65000003300000042116e+00,'participant','2031-07-23T16:44:36.352Z',6);
INSERT INTO "answer" VALUES(39,2,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:40.378Z',6);
INSERT INTO "answer" VALUES(40,2,'trial/2/grade/grade',1,'trial',2,'grade','grade',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:44:50.443Z',7);
INSERT INTO "answer" VALUES(41,2,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:54.469Z',7);
INSERT INTO "answer" VALUES(42,2,'trial/3/grade/grade',1,'trial',3,'grade','grade',5.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:06.547Z',8);
INSERT INTO "answer" VALUES(43,2,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:10.573Z',8);
INSERT INTO "answer" VALUES(44,2,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:14.599Z',NULL);
INSERT INTO "answer" VALUES(45,2,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:18.625Z',NULL);
INSERT INTO "answer" VALUES(46,2,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:22.651Z',NULL);
INSERT INTO "answer" VALUES(47,2,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:26.677Z',NULL);
INSERT INTO "answer" VALUES(48,2,'after/vrsq/headache',1,'after',0,'vrsq','headache',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:30.703Z',NULL);
INSERT INTO "answer" VALUES(49,2,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:34.729Z',NULL);
INSERT INTO "answer" VALUES(50,2,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:38.755Z',NULL);
INSERT INTO "answer" VALUES(51,2,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:42.781Z',NULL);
INSERT INTO "answer" VALUES(52,2,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:46.807Z',NULL);
INSERT INTO "answer" VALUES(53,3,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:02.911Z',NULL);
INSERT INTO "answer" VALUES(54,3,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:06.937Z',NULL);
INSERT INTO "answer" VALUES(55,3,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:10.963Z',NULL);
INSERT INTO "answer" VALUES(56,3,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:14.989Z',NULL);
INSERT INTO "answer" VALUES(57,3,'before/vrsq/headache',1,'before',0,'vrsq','headache',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:19.015Z',NULL);
INSERT INTO "answer" VALUES(58,3,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:23.041Z',NULL);
INSERT INTO "answer" VALUES(59,3,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:27.067Z',NULL);
INSERT INTO "answer" VALUES(60,3,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:31.093Z',NULL);
INSERT INTO "answer" VALUES(61,3,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:35.119Z',NULL);
INSERT INTO "answer" VALUES(62,3,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:45.184Z',9);
INSERT INTO "answer" VALUES(63,3,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:46:55.249Z',10);
INSERT INTO "answer" VALUES(64,3,'trial/1/grade/grade',2,'trial',1,'grade','grade',3.25,3.65000003300000042116e+00,'participant','2031-07-23T16:46:59.275Z',10);
INSERT INTO "answer" VALUES(65,3,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:03.301Z',10);
INSERT INTO "answer" VALUES(66,3,'trial/2/grade/grade',1,'trial',2,'grade','grade',5.5,3.65000003300000042116e+00,'participant','2031-07-23T16:47:13.366Z',11);
INSERT INTO "answer" VALUES(67,3,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:17.392Z',11);
INSERT INTO "answer" VALUES(68,3,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.25,3.65000003300000042116e+00,'participant','2031-07-23T16:47:29.470Z',12);
INSERT INTO "answer" VALUES(69,3,'trial/3/fms/fms',1,'trial',3,'fms','fms',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:33.496Z',12);
INSERT INTO "answer" VALUES(70,3,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:37.522Z',NULL);
INSERT INTO "answer" VALUES(71,3,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:41.548Z',NULL);
INSERT INTO "answer" VALUES(72,3,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:45.574Z',NULL);
INSERT INTO "answer" VALUES(73,3,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:49.600Z',NULL);
INSERT INTO "answer" VALUES(74,3,'after/vrsq/headache',1,'after',0,'vrsq','headache',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:53.626Z',NULL);
INSERT INTO "answer" VALUES(75,3,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:57.652Z',NULL);
INSERT INTO "answer" VALUES(76,3,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:01.678Z',NULL);
INSERT INTO "answer" VALUES(77,3,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:05.704Z',NULL);
INSERT INTO "answer" VALUES(78,3,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:48:09.730Z',NULL);
INSERT INTO "answer" VALUES(79,4,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',3.0,4.650000033,'participant','2031-07-23T16:48:25.834Z',NULL);
INSERT INTO "answer" VALUES(80,4,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',0.0,4.650000033,'participant','2031-07-23T16:48:29.860Z',NULL);
INSERT INTO "answer" VALUES(81,4,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',0.0,4.650000033,'participant','2031-07-23T16:48:33.886Z',NULL);
INSERT INTO "answer" VALUES(82,4,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',0.0,4.650000033,'participant','2031-07-23T16:48:37.912Z',NULL);
INSERT INTO "answer" VALUES(83,4,'before/vrsq/headache',1,'before',0,'vrsq','headache',0.0,4.650000033,'participant','2031-07-23T16:48:41.938Z',NULL);
INSERT INTO "answer" VALUES(84,4,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',3.0,4.650000033,'participant','2031-07-23T16:48:45.964Z',NULL);
INSERT INTO "answer" VALUES(85,4,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',3.0,4.650000033,'participant','2031-07-23T16:48:49.990Z',NULL);
INSERT INTO "answer" VALUES(86,4,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',2.0,4.650000033,'participant','2031-07-23T16:48:54.016Z',NULL);
INSERT INTO "answer" VALUES(87,4,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',0.0,4.650000033,'participant','2031-07-23T16:48:58.042Z',NULL);
INSERT INTO "answer" VALUES(88,4,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,4.650000033,'participant','2031-07-23T16:49:08.107Z',13);
INSERT INTO "answer" VALUES(89,4,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:49:24.211Z',15);
INSERT INTO "answer" VALUES(90,4,'trial/1/grade/grade',2,'trial',1,'grade','grade',5.0,4.650000033,'participant','2031-07-23T16:49:28.237Z',15);
INSERT INTO "answer" VALUES(91,4,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,4.650000033,'participant','2031-07-23T16:49:32.263Z',15);
INSERT INTO "answer" VALUES(92,4,'trial/2/grade/grade',1,'trial',2,'grade','grade',1.25,4.650000033,'participant','2031-07-23T16:49:42.328Z',16);
INSERT INTO "answer" VALUES(93,4,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,4.650000033,'participant','2031-07-23T16:49:46.354Z',16);
INSERT INTO "answer" VALUES(94,4,'trial/3/grade/grade',1,'trial',3,'grade','grade',3.25,4.650000033,'participant','2031-07-23T16:49:58.432Z',17);
INSERT INTO "answer" VALUES(95,4,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,4.650000033,'participant','2031-07-23T16:50:02.458Z',17);
INSERT INTO "answer" VALUES(96,4,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',0.0,4.650000033,'participant','2031-07-23T16:50:06.484Z',NULL);
INSERT INTO "answer" VALUES(97,4,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',1.0,4.650000033,'participant','2031-07-23T16:50:10.510Z',NULL);
INSERT INTO "answer" VALUES(98,4,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',1.0,4.650000033,'participant','2031-07-23T16:50:14.536Z',NULL);
INSERT INTO "answer" VALUES(99,4,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,4.650000033,'participant','2031-07-23T16:50:18.562Z',NULL);
INSERT INTO "answer" VALUES(100,4,'after/vrsq/headache',1,'after',0,'vrsq','headache',2.0,4.650000033,'participant','2031-07-23T16:50:22.588Z',NULL);
INSERT INTO "answer" VALUES(101,4,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',1.0,4.650000033,'participant','2031-07-23T16:50:26.614Z',NULL);
INSERT INTO "answer" VALUES(102,4,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,4.650000033,'participant','2031-07-23T16:50:30.640Z',NULL);
INSERT INTO "answer" VALUES(103,4,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',2.0,4.650000033,'participant','2031-07-23T16:50:34.666Z',NULL);
INSERT INTO "answer" VALUES(104,4,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',2.0,4.650000033,'participant','2031-07-23T16:50:38.692Z',NULL);
INSERT INTO "answer" VALUES(105,5,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',2.0,5.650000033,'participant','2031-07-23T16:50:54.796Z',NULL);
INSERT INTO "answer" VALUES(106,5,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',3.0,5.650000033,'participant','2031-07-23T16:50:58.822Z',NULL);
INSERT INTO "answer" VALUES(107,5,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',3.0,5.650000033,'participant','2031-07-23T16:51:02.848Z',NULL);
INSERT INTO "answer" VALUES(108,5,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',2.0,5.650000033,'participant','2031-07-23T16:51:06.874Z',NULL);
INSERT INTO "answer" VALUES(109,5,'before/vrsq/headache',1,'before',0,'vrsq','headache',3.0,5.650000033,'participant','2031-07-23T16:51:10.900Z',NULL);
INSERT INTO "answer" VALUES(110,5,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',3.0,5.650000033,'participant','2031-07-23T16:51:14.926Z',NULL);
INSERT INTO "answer" VALUES(111,5,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',3.0,5.650000033,'participant','2031-07-23T16:51:18.952Z',NULL);
INSERT INTO "answer" VALUES(112,5,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',0.0,5.650000033,'participant','2031-07-23T16:51:22.978Z',NULL);
INSERT INTO "answer" VALUES(113,5,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',1.0,5.650000033,'participant','2031-07-23T16:51:27.004Z',NULL);
INSERT INTO "answer" VALUES(114,5,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,5.650000033,'participant','2031-07-23T16:51:37.069Z',18);
INSERT INTO "answer" VALUES(115,5,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:51:47.134Z',19);
INSERT INTO "answer" VALUES(116,5,'trial/1/grade/grade',2,'trial',1,'grade','grade',2.75,5.650000033,'participant','2031-07-23T16:51:51.160Z',19);
INSERT INTO "answer" VALUES(117,5,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,5.650000033,'participant','2031-07-23T16:51:55.186Z',19);
INSERT INTO "answer" VALUES(118,5,'trial/2/grade/grade',1,'trial',2,'grade','grade',1.5,5.650000033,'participant','2031-07-23T16:52:05.251Z',20);
INSERT INTO "answer" VALUES(119,5,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,5.650000033,'participant','2031-07-23T16:52:09.277Z',20);
INSERT INTO "answer" VALUES(120,5,'trial/3/grade/grade',1,'trial',3,'grade','grade',5.5,5.650000033,'participant','2031-07-23T16:52:21.355Z',21);
INSERT INTO "answer" VALUES(121,5,'trial/3/fms/fms',1,'trial',3,'fms','fms',3.0,5.650000033,'participant','2031-07-23T16:52:25.381Z',21);
INSERT INTO "answer" VALUES(122,5,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',2.0,5.650000033,'participant','2031-07-23T16:52:29.407Z',NULL);
INSERT INTO "answer" VALUES(123,5,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',1.0,5.650000033,'participant','2031-07-23T16:52:33.433Z',NULL);
INSERT INTO "answer" VALUES(124,5,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',3.0,5.650000033,'participant','2031-07-23T16:52:37.459Z',NULL);
INSERT INTO "answer" VALUES(125,5,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',0.0,5.650000033,'participant','2031-07-23T16:52:41.485Z',NULL);
INSERT INTO "answer" VALUES(126,5,'after/vrsq/headache',1,'after',0,'vrsq','headache',1.0,5.650000033,'participant','2031-07-23T16:52:45.511Z',NULL);
INSERT INTO "answer" VALUES(127,5,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',3.0,5.650000033,'participant','2031-07-23T16:52:49.537Z',NULL);
INSERT INTO "answer" VALUES(128,5,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,5.650000033,'participant','2031-07-23T16:52:53.563Z',NULL);
INSERT INTO "answer" VALUES(129,5,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',0.0,5.650000033,'participant','2031-07-23T16:52:57.589Z',NULL);
INSERT INTO "answer" VALUES(130,5,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',3.0,5.650000033,'participant','2031-07-23T16:53:01.615Z',NULL);
INSERT INTO "answer" VALUES(131,6,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',2.0,6.650000033,'participant','2031-07-23T16:53:17.719Z',NULL);
INSERT INTO "answer" VALUES(132,6,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',3.0,6.650000033,'participant','2031-07-23T16:53:21.745Z',NULL);
INSERT INTO "answer" VALUES(133,6,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',0.0,6.650000033,'participant','2031-07-23T16:53:25.771Z',NULL);
INSERT INTO "answer" VALUES(134,6,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',3.0,6.650000033,'participant','2031-07-23T16:53:29.797Z',NULL);
INSERT INTO "answer" VALUES(135,6,'before/vrsq/headache',1,'before',0,'vrsq','headache',1.0,6.650000033,'participant','2031-07-23T16:53:33.823Z',NULL);
INSERT INTO "answer" VALUES(136,6,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',2.0,6.650000033,'participant','2031-07-23T16:53:37.849Z',NULL);
INSERT INTO "answer" VALUES(137,6,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',2.0,6.650000033,'participant','2031-07-23T16:53:41.875Z',NULL);
INSERT INTO "answer" VALUES(138,6,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',1.0,6.650000033,'participant','2031-07-23T16:53:45.901Z',NULL);
INSERT INTO "answer" VALUES(139,6,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',3.0,6.650000033,'participant','2031-07-23T16:53:49.927Z',NULL);
INSERT INTO "answer" VALUES(140,6,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,6.650000033,'participant','2031-07-23T16:53:59.992Z',22);
INSERT INTO "answer" VALUES(141,6,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:54:10.057Z',23);
INSERT INTO "answer" VALUES(142,6,'trial/1/grade/grade',2,'trial',1,'grade','grade',6.0,6.650000033,'participant','2031-07-23T16:54:14.083Z',23);
INSERT INTO "answer" VALUES(143,6,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,6.650000033,'participant','2031-07-23T16:54:18.109Z',23);
INSERT INTO "answer" VALUES(144,6,'trial/2/grade/grade',1,'trial',2,'grade','grade',4.5,6.650000033,'participant','2031-07-23T16:54:28.174Z',24);
INSERT INTO "answer" VALUES(145,6,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,6.650000033,'participant','2031-07-23T16:54:32.200Z',24);
INSERT INTO "answer" VALUES(146,6,'trial/3/grade/grade',1,'trial',3,'grade','grade',2.5,6.650000033,'participant','2031-07-23T16:54:44.278Z',25);
INSERT INTO "answer" VALUES(147,6,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,6.650000033,'participant','2031-07-23T16:54:48.304Z',25);
INSERT INTO "answer" VALUES(148,6,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',3.0,6.650000033,'participant','2031-07-23T16:54:52.330Z',NULL);
INSERT INTO "answer" VALUES(149,6,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',0.0,6.650000033,'participant','2031-07-23T16:54:56.356Z',NULL);
INSERT INTO "answer" VALUES(150,6,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',2.0,6.650000033,'participant','2031-07-23T16:55:00.382Z',NULL);
INSERT INTO "answer" VALUES(151,6,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,6.650000033,'participant','2031-07-23T16:55:04.408Z',NULL);
INSERT INTO "answer" VALUES(152,6,'after/vrsq/headache',1,'after',0,'vrsq','headache',0.0,6.650000033,'participant','2031-07-23T16:55:08.434Z',NULL);
INSERT INTO "answer" VALUES(153,6,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',1.0,6.650000033,'participant','2031-07-23T16:55:12.460Z',NULL);
INSERT INTO "answer" VALUES(154,6,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,6.650000033,'participant','2031-07-23T16:55:16.486Z',NULL);
INSERT INTO "answer" VALUES(155,6,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',1.0,6.650000033,'participant','2031-07-23T16:55:20.512Z',NULL);
INSERT INTO "answer" VALUES(156,6,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',3.0,6.650000033,'participant','2031-07-23T16:55:24.538Z',NULL);
INSERT INTO "answer" VALUES(157,7,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',1.0,7.650000033,'participant','2031-07-23T16:55:40.642Z',NULL);
INSERT INTO "answer" VALUES(158,7,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',2.0,7.650000033,'participant','2031-07-23T16:55:44.668Z',NULL);
INSERT INTO "answer" VALUES(159,7,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',2.0,7.650000033,'participant','2031-07-23T16:55:48.694Z',NULL);
INSERT INTO "answer" VALUES(160,7,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',1.0,7.650000033,'participant','2031-07-23T16:55:52.720Z',NULL);
INSERT INTO "answer" VALUES(161,7,'before/vrsq/headache',1,'before',0,'vrsq','headache',3.0,7.650000033,'participant','2031-07-23T16:55:56.746Z',NULL);
INSERT INTO "answer" VALUES(162,7,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',1.0,7.650000033,'participant','2031-07-23T16:56:00.772Z',NULL);
INSERT INTO "answer" VALUES(163,7,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',2.0,7.650000033,'participant','2031-07-23T16:56:04.798Z',NULL);
INSERT INTO "answer" VALUES(164,7,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',1.0,7.650000033,'participant','2031-07-23T16:56:08.824Z',NULL);
INSERT INTO "answer" VALUES(165,7,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',1.0,7.650000033,'participant','2031-07-23T16:56:12.850Z',NULL);
INSERT INTO "answer" VALUES(166,7,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,7.650000033,'participant','2031-07-23T16:56:22.915Z',26);
INSERT INTO "answer" VALUES(167,7,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:56:32.980Z',27);
INSERT INTO "answer" VALUES(168,7,'trial/1/grade/grade',2,'trial',1,'grade','grade',3.25,7.650000033,'participant','2031-07-23T16:56:37.006Z',27);
INSERT INTO "answer" VALUES(169,7,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,7.650000033,'participant','2031-07-23T16:56:41.032Z',27);
INSERT INTO "answer" VALUES(170,7,'trial/2/grade/grade',1,'trial',2,'grade','grade',5.25,7.650000033,'participant','2031-07-23T16:56:51.097Z',28);
INSERT INTO "answer" VALUES(171,7,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,7.650000033,'participant','2031-07-23T16:56:55.123Z',28);
INSERT INTO "answer" VALUES(172,7,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.75,7.650000033,'participant','2031-07-23T16:57:07.201Z',29);
INSERT INTO "answer" VALUES(173,7,'trial/3/fms/fms',1,'trial',3,'fms','fms',3.0,7.650000033,'participant','2031-07-23T16:57:11.227Z',29);
INSERT INTO "answer" VALUES(174,7,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',0.0,7.650000033,'participant','2031-07-23T16:57:15.253Z',NULL);
INSERT INTO "answer" VALUES(175,7,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',2.0,7.650000033,'participant','2031-07-23T16:57:19.279Z',NULL);
INSERT INTO "answer" VALUES(176,7,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',0.0,7.650000033,'participant','2031-07-23T16:57:23.305Z',NULL);
INSERT INTO "answer" VALUES(177,7,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,7.650000033,'participant','2031-07-23T16:57:27.331Z',NULL);
INSERT INTO "answer" VALUES(178,7,'after/vrsq/headache',1,'after',0,'vrsq','headache',3.0,7.650000033,'participant','2031-07-23T16:57:31.357Z',NULL);
INSERT INTO "answer" VALUES(179,7,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',3.0,7.650000033,'participant','2031-07-23T16:57:35.383Z',NULL);
INSERT INTO "answer" VALUES(180,7,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',0.0,7.650000033,'participant','2031-07-23T16:57:39.409Z',NULL);
INSERT INTO "answer" VALUES(181,7,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',3.0,7.650000033,'participant','2031-07-23T16:57:43.435Z',NULL);
INSERT INTO "answer" VALUES(182,7,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',3.0,7.650000033,'participant','2031-07-23T16:57:47.461Z',NULL);
INSERT INTO "answer" VALUES(183,8,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',3.0,8.650000033,'participant','2031-07-23T16:58:03.565Z',NULL);
INSERT INTO "answer" VALUES(184,8,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',2.0,8.650000033,'participant','2031-07-23T16:58:07.591Z',NULL);
INSERT INTO "answer" VALUES(185,8,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',2.0,8.650000033,'participant','2031-07-23T16:58:11.617Z',NULL);
INSERT INTO "answer" VALUES(186,8,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',3.0,8.650000033,'participant','2031-07-23T16:58:15.643Z',NULL);
INSERT INTO "answer" VALUES(187,8,'before/vrsq/headache',1,'before',0,'vrsq','headache',2.0,8.650000033,'participant','2031-07-23T16:58:19.669Z',NULL);
INSERT INTO "answer" VALUES(188,8,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',3.0,8.650000033,'participant','2031-07-23T16:58:23.695Z',NULL);
INSERT INTO "answer" VALUES(189,8,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',3.0,8.650000033,'participant','2031-07-23T16:58:27.721Z',NULL);
INSERT INTO "answer" VALUES(190,8,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',0.0,8.650000033,'participant','2031-07-23T16:58:31.747Z',NULL);
INSERT INTO "answer" VALUES(191,8,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',0.0,8.650000033,'participant','2031-07-23T16:58:35.773Z',NULL);
INSERT INTO "answer" VALUES(192,8,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,8.650000033,'participant','2031-07-23T16:58:45.838Z',30);
INSERT INTO "answer" VALUES(193,8,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:58:55.903Z',31);
INSERT INTO "answer" VALUES(194,8,'trial/1/grade/grade',2,'trial',1,'grade','grade',5.5,8.650000033,'participant','2031-07-23T16:58:59.929Z',31);
INSERT INTO "answer" VALUES(195,8,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,8.650000033,'participant','2031-07-23T16:59:03.955Z',31);
INSERT INTO "answer" VALUES(196,8,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.0,8.650000033,'participant','2031-07-23T16:59:14.020Z',32);
INSERT INTO "answer" VALUES(197,8,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,8.650000033,'participant','2031-07-23T16:59:18.046Z',32);
INSERT INTO "answer" VALUES(198,8,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.75,8.650000033,'participant','2031-07-23T16:59:30.124Z',33);
INSERT INTO "answer" VALUES(199,8,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,8.650000033,'participant','2031-07-23T16:59:34.150Z',33);
INSERT INTO "answer" VALUES(200,8,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',1.0,8.650000033,'participant','2031-07-23T16:59:38.176Z',NULL);
INSERT INTO "answer" VALUES(201,8,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',3.0,8.650000033,'participant','2031-07-23T16:59:42.202Z',NULL);
INSERT INTO "answer" VALUES(202,8,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',1.0,8.650000033,'participant','2031-07-23T16:59:46.228Z',NULL);
INSERT INTO "answer" VALUES(203,8,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',1.0,8.650000033,'participant','2031-07-23T16:59:50.254Z',NULL);
INSERT INTO "answer" VALUES(204,8,'after/vrsq/headache',1,'after',0,'vrsq','headache',1.0,8.650000033,'participant','2031-07-23T16:59:54.280Z',NULL);
INSERT INTO "answer" VALUES(205,8,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,8.650000033,'participant','2031-07-23T16:59:58.306Z',NULL);
INSERT INTO "answer" VALUES(206,8,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,8.650000033,'participant','2031-07-23T17:00:02.332Z',NULL);
INSERT INTO "answer" VALUES(207,8,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',3.0,8.650000033,'participant','2031-07-23T17:00:06.358Z',NULL);
INSERT INTO "answer" VALUES(208,8,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',1.0,8.650000033,'participant','2031-07-23T17:00:10.384Z',NULL);
INSERT INTO "answer" VALUES(209,9,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',2.0,9.650000033,'participant','2031-07-23T17:00:26.488Z',NULL);
INSERT INTO "answer" VALUES(210,9,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',1.0,9.650000033,'participant','2031-07-23T17:00:30.514Z',NULL);
INSERT INTO "answer" VALUES(211,9,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',0.0,9.650000033,'participant','2031-07-23T17:00:34.540Z',NULL);
INSERT INTO "answer" VALUES(212,9,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',3.0,9.650000033,'participant','2031-07-23T17:00:38.566Z',NULL);
INSERT INTO "answer" VALUES(213,9,'before/vrsq/headache',1,'before',0,'vrsq','headache',0.0,9.650000033,'participant','2031-07-23T17:00:42.592Z',NULL);
INSERT INTO "answer" VALUES(214,9,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',1.0,9.650000033,'participant','2031-07-23T17:00:46.618Z',NULL);
INSERT INTO "answer" VALUES(215,9,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',2.0,9.650000033,'participant','2031-07-23T17:00:50.644Z',NULL);
INSERT INTO "answer" VALUES(216,9,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',3.0,9.650000033,'participant','2031-07-23T17:00:54.670Z',NULL);
INSERT INTO "answer" VALUES(217,9,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',2.0,9.650000033,'participant','2031-07-23T17:00:58.696Z',NULL);
INSERT INTO "answer" VALUES(218,9,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,9.650000033,'participant','2031-07-23T17:01:08.761Z',34);
INSERT INTO "answer" VALUES(219,9,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T17:01:18.826Z',35);
INSERT INTO "answer" VALUES(220,9,'trial/1/grade/grade',2,'trial',1,'grade','grade',1.25,9.650000033,'participant','2031-07-23T17:01:22.852Z',35);
INSERT INTO "answer" VALUES(221,9,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,9.650000033,'participant','2031-07-23T17:01:26.878Z',35);
INSERT INTO "answer" VALUES(222,10,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',1.0,10.650000033,'participant','2031-07-23T17:01:42.982Z',NULL);
INSERT INTO "answer" VALUES(223,10,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',3.0,10.650000033,'participant','2031-07-23T17:01:47.008Z',NULL);
INSERT INTO "answer" VALUES(224,10,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',3.0,10.650000033,'participant','2031-07-23T17:01:51.034Z',NULL);
INSERT INTO "answer" VALUES(225,10,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',1.0,10.650000033,'participant','2031-07-23T17:01:55.060Z',NULL);
INSERT INTO "answer" VALUES(226,10,'before/vrsq/headache',1,'before',0,'vrsq','headache',0.0,10.650000033,'participant','2031-07-23T17:01:59.086Z',NULL);
INSERT INTO "answer" VALUES(227,10,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',2.0,10.650000033,'participant','2031-07-23T17:02:03.112Z',NULL);
INSERT INTO "answer" VALUES(228,10,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',2.0,10.650000033,'participant','2031-07-23T17:02:07.138Z',NULL);
INSERT INTO "answer" VALUES(229,10,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',3.0,10.650000033,'participant','2031-07-23T17:02:11.164Z',NULL);
INSERT INTO "answer" VALUES(230,10,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',2.0,10.650000033,'participant','2031-07-23T17:02:15.190Z',NULL);
INSERT INTO "answer" VALUES(231,10,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,10.650000033,'participant','2031-07-23T17:02:25.255Z',36);
INSERT INTO "answer" VALUES(232,10,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T17:02:35.320Z',37);
INSERT INTO "answer" VALUES(233,10,'trial/1/grade/grade',2,'trial',1,'grade','grade',2.0,10.650000033,'participant','2031-07-23T17:02:39.346Z',37);
INSERT INTO "answer" VALUES(234,10,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,10.650000033,'participant','2031-07-23T17:02:43.372Z',37);
INSERT INTO "answer" VALUES(235,10,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.25,10.650000033,'participant','2031-07-23T17:02:53.437Z',38);
INSERT INTO "answer" VALUES(236,10,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,10.650000033,'participant','2031-07-23T17:02:57.463Z',38);
INSERT INTO "answer" VALUES(237,12,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',2.0,13.650000033,'participant','2031-07-23T17:03:27.658Z',NULL);
INSERT INTO "answer" VALUES(238,12,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',1.0,13.650000033,'participant','2031-07-23T17:03:31.684Z',NULL);
INSERT INTO "answer" VALUES(239,12,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',3.0,13.650000033,'participant','2031-07-23T17:03:35.710Z',NULL);
INSERT INTO "answer" VALUES(240,12,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',3.0,13.650000033,'participant','2031-07-23T17:03:39.736Z',NULL);
INSERT INTO "answer" VALUES(241,12,'before/vrsq/headache',1,'before',0,'vrsq','headache',0.0,13.650000033,'participant','2031-07-23T17:03:43.762Z',NULL);
INSERT INTO "answer" VALUES(242,12,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',0.0,13.650000033,'participant','2031-07-23T17:03:47.788Z',NULL);
INSERT INTO "answer" VALUES(243,12,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',0.0,13.650000033,'participant','2031-07-23T17:03:51.814Z',NULL);
INSERT INTO "answer" VALUES(244,12,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',0.0,13.650000033,'participant','2031-07-23T17:03:55.840Z',NULL);
INSERT INTO "answer" VALUES(245,12,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',2.0,13.650000033,'participant','2031-07-23T17:03:59.866Z',NULL);
INSERT INTO "answer" VALUES(246,12,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,13.650000033,'participant','2031-07-23T17:04:09.931Z',39);
INSERT INTO "answer" VALUES(247,12,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T17:04:19.996Z',40);
INSERT INTO "answer" VALUES(248,12,'trial/1/grade/grade',2,'trial',1,'grade','grade',1.25,13.650000033,'participant','2031-07-23T17:04:24.022Z',40);
INSERT INTO "answer" VALUES(249,12,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,13.650000033,'participant','2031-07-23T17:04:28.048Z',40);
INSERT INTO "answer" VALUES(250,12,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.25,13.650000033,'participant','2031-07-23T17:04:38.113Z',41);
INSERT INTO "answer" VALUES(251,12,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,13.650000033,'participant','2031-07-23T17:04:42.139Z',41);
INSERT INTO "answer" VALUES(252,13,'before/vrsq/general_discomfort',1,'before',0,'vrsq','general_discomfort',0.0,12.650000033,'participant','2031-07-23T17:05:00.256Z',NULL);
INSERT INTO "answer" VALUES(253,13,'before/vrsq/fatigue',1,'before',0,'vrsq','fatigue',0.0,12.650000033,'participant','2031-07-23T17:05:04.282Z',NULL);
INSERT INTO "answer" VALUES(254,13,'before/vrsq/eyestrain',1,'before',0,'vrsq','eyestrain',3.0,12.650000033,'participant','2031-07-23T17:05:08.308Z',NULL);
INSERT INTO "answer" VALUES(255,13,'before/vrsq/difficulty_focusing',1,'before',0,'vrsq','difficulty_focusing',1.0,12.650000033,'participant','2031-07-23T17:05:12.334Z',NULL);
INSERT INTO "answer" VALUES(256,13,'before/vrsq/headache',1,'before',0,'vrsq','headache',2.0,12.650000033,'participant','2031-07-23T17:05:16.360Z',NULL);
INSERT INTO "answer" VALUES(257,13,'before/vrsq/fullness_of_head',1,'before',0,'vrsq','fullness_of_head',2.0,12.650000033,'participant','2031-07-23T17:05:20.386Z',NULL);
INSERT INTO "answer" VALUES(258,13,'before/vrsq/blurred_vision',1,'before',0,'vrsq','blurred_vision',2.0,12.650000033,'participant','2031-07-23T17:05:24.412Z',NULL);
INSERT INTO "answer" VALUES(259,13,'before/vrsq/dizzy_eyes_closed',1,'before',0,'vrsq','dizzy_eyes_closed',0.0,12.650000033,'participant','2031-07-23T17:05:28.438Z',NULL);
INSERT INTO "answer" VALUES(260,13,'before/vrsq/vertigo',1,'before',0,'vrsq','vertigo',1.0,12.650000033,'participant','2031-07-23T17:05:32.464Z',NULL);
INSERT INTO "answer" VALUES(261,13,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,12.650000033,'participant','2031-07-23T17:05:42.529Z',42);
INSERT INTO "answer" VALUES(262,13,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T17:05:52.594Z',43);
INSERT INTO "answer" VALUES(263,13,'trial/1/grade/grade',2,'trial',1,'grade','grade',5.5,12.650000033,'participant','2031-07-23T17:05:56.620Z',43);
INSERT INTO "answer" VALUES(264,13,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,12.650000033,'participant','2031-07-23T17:06:00.646Z',43);
INSERT INTO "answer" VALUES(265,13,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.0,12.650000033,'participant','2031-07-23T17:06:10.711Z',44);
INSERT INTO "answer" VALUES(266,13,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,12.650000033,'participant','2031-07-23T17:06:14.737Z',44);
INSERT INTO "answer" VALUES(267,13,'trial/3/grade/grade',1,'trial',3,'grade','grade',2.0,12.650000033,'participant','2031-07-23T17:06:26.815Z',45);
INSERT INTO "answer" VALUES(268,13,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,12.650000033,'participant','2031-07-23T17:06:30.841Z',45);
INSERT INTO "answer" VALUES(269,13,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',2.0,12.650000033,'participant','2031-07-23T17:06:34.867Z',NULL);
INSERT INTO "answer" VALUES(270,13,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',3.0,12.650000033,'participant','2031-07-23T17:06:38.893Z',NULL);
INSERT INTO "answer" VALUES(271,13,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',1.0,12.650000033,'participant','2031-07-23T17:06:42.919Z',NULL);
INSERT INTO "answer" VALUES(272,13,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',0.0,12.650000033,'participant','2031-07-23T17:06:46.945Z',NULL);
INSERT INTO "answer" VALUES(273,13,'after/vrsq/headache',1,'after',0,'vrsq','headache',2.0,12.650000033,'participant','2031-07-23T17:06:50.971Z',NULL);
INSERT INTO "answer" VALUES(274,13,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',1.0,12.650000033,'participant','2031-07-23T17:06:54.997Z',NULL);
INSERT INTO "answer" VALUES(275,13,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',2.0,12.650000033,'participant','2031-07-23T17:06:59.023Z',NULL);
INSERT INTO "answer" VALUES(276,13,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',3.0,12.650000033,'participant','2031-07-23T17:07:03.049Z',NULL);
INSERT INTO "answer" VALUES(277,13,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',1.0,12.650000033,'participant','2031-07-23T17:07:07.075Z',NULL);
CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  kind TEXT NOT NULL,
  key TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  mono_ns INTEGER NOT NULL,
  data TEXT NOT NULL
) STRICT;
INSERT INTO "event" VALUES(1,1,'begin','','2031-07-23T16:41:13.039Z',2013000000,'{"part":"main","row":2,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(2,1,'finished','consent','2031-07-23T16:41:15.052Z',4026000000,'{}');
INSERT INTO "event" VALUES(3,1,'answer','before/vrsq/general_discomfort','2031-07-23T16:41:19.078Z',6039000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(4,1,'answer','before/vrsq/fatigue','2031-07-23T16:41:23.104Z',8052000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(5,1,'answer','before/vrsq/eyestrain','2031-07-23T16:41:27.130Z',10065000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(6,1,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:41:31.156Z',12078000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(7,1,'answer','before/vrsq/headache','2031-07-23T16:41:35.182Z',14091000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(8,1,'answer','before/vrsq/fullness_of_head','2031-07-23T16:41:39.208Z',16104000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(9,1,'answer','before/vrsq/blurred_vision','2031-07-23T16:41:43.234Z',18117000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(10,1,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:41:47.260Z',20130000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(11,1,'answer','before/vrsq/vertigo','2031-07-23T16:41:51.286Z',22143000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(12,1,'showing','practice','2031-07-23T16:41:55.312Z',24156000000,'{"showing":1,"presentation":1}');
INSERT INTO "event" VALUES(13,1,'shown','practice','2031-07-23T16:41:57.325Z',26169000000,'{"showing":1,"complete":true}');
INSERT INTO "event" VALUES(14,1,'answer','practice/fms/fms','2031-07-23T16:42:01.351Z',28182000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(15,1,'showing','trial/1','2031-07-23T16:42:05.377Z',30195000000,'{"showing":2,"presentation":1}');
INSERT INTO "event" VALUES(16,1,'shown','trial/1','2031-07-23T16:42:07.390Z',32208000000,'{"showing":2,"complete":true}');
INSERT INTO "event" VALUES(17,1,'answer','trial/1/grade/grade','2031-07-23T16:42:11.416Z',34221000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(18,1,'answer','trial/1/grade/grade','2031-07-23T16:42:15.442Z',36234000000,'{"value":5.5,"revision":2}');
INSERT INTO "event" VALUES(19,1,'answer','trial/1/fms/fms','2031-07-23T16:42:19.468Z',38247000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(20,1,'showing','trial/2','2031-07-23T16:42:23.494Z',40260000000,'{"showing":3,"presentation":1}');
INSERT INTO "event" VALUES(21,1,'shown','trial/2','2031-07-23T16:42:25.507Z',42273000000,'{"showing":3,"complete":true}');
INSERT INTO "event" VALUES(22,1,'answer','trial/2/grade/grade','2031-07-23T16:42:29.533Z',44286000000,'{"value":3.5,"revision":1}');
INSERT INTO "event" VALUES(23,1,'answer','trial/2/fms/fms','2031-07-23T16:42:33.559Z',46299000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(24,1,'finished','break/1','2031-07-23T16:42:35.572Z',48312000000,'{}');
INSERT INTO "event" VALUES(25,1,'showing','trial/3','2031-07-23T16:42:39.598Z',50325000000,'{"showing":4,"presentation":1}');
INSERT INTO "event" VALUES(26,1,'shown','trial/3','2031-07-23T16:42:41.611Z',52338000000,'{"showing":4,"complete":true}');
INSERT INTO "event" VALUES(27,1,'answer','trial/3/grade/grade','2031-07-23T16:42:45.637Z',54351000000,'{"value":1.5,"revision":1}');
INSERT INTO "event" VALUES(28,1,'answer','trial/3/fms/fms','2031-07-23T16:42:49.663Z',56364000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(29,1,'answer','after/vrsq/general_discomfort','2031-07-23T16:42:53.689Z',58377000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(30,1,'answer','after/vrsq/fatigue','2031-07-23T16:42:57.715Z',60390000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(31,1,'answer','after/vrsq/eyestrain','2031-07-23T16:43:01.741Z',62403000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(32,1,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:43:05.767Z',64416000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(33,1,'answer','after/vrsq/headache','2031-07-23T16:43:09.793Z',66429000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(34,1,'answer','after/vrsq/fullness_of_head','2031-07-23T16:43:13.819Z',68442000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(35,1,'answer','after/vrsq/blurred_vision','2031-07-23T16:43:17.845Z',70455000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(36,1,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:43:21.871Z',72468000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(37,1,'answer','after/vrsq/vertigo','2031-07-23T16:43:25.897Z',74481000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(38,1,'remark','trial/1','2031-07-23T16:43:27.910Z',76494000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(39,1,'end','','2031-07-23T16:43:29.923Z',78507000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(40,2,'begin','','2031-07-23T16:43:35.962Z',80520000000,'{"part":"main","row":5,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(41,2,'finished','consent','2031-07-23T16:43:37.975Z',82533000000,'{}');
INSERT INTO "event" VALUES(42,2,'answer','before/vrsq/general_discomfort','2031-07-23T16:43:42.001Z',84546000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(43,2,'answer','before/vrsq/fatigue','2031-07-23T16:43:46.027Z',86559000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(44,2,'answer','before/vrsq/eyestrain','2031-07-23T16:43:50.053Z',88572000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(45,2,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:43:54.079Z',90585000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(46,2,'answer','before/vrsq/headache','2031-07-23T16:43:58.105Z',92598000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(47,2,'answer','before/vrsq/fullness_of_head','2031-07-23T16:44:02.131Z',94611000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(48,2,'answer','before/vrsq/blurred_vision','2031-07-23T16:44:06.157Z',96624000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(49,2,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:44:10.183Z',98637000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(50,2,'answer','before/vrsq/vertigo','2031-07-23T16:44:14.209Z',100650000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(51,2,'showing','practice','2031-07-23T16:44:18.235Z',102663000000,'{"showing":5,"presentation":1}');
INSERT INTO "event" VALUES(52,2,'shown','practice','2031-07-23T16:44:20.248Z',104676000000,'{"showing":5,"complete":true}');
INSERT INTO "event" VALUES(53,2,'answer','practice/fms/fms','2031-07-23T16:44:24.274Z',106689000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(54,2,'showing','trial/1','2031-07-23T16:44:28.300Z',108702000000,'{"showing":6,"presentation":1}');
INSERT INTO "event" VALUES(55,2,'shown','trial/1','2031-07-23T16:44:30.313Z',110715000000,'{"showing":6,"complete":true}');
INSERT INTO "event" VALUES(56,2,'answer','trial/1/grade/grade','2031-07-23T16:44:34.339Z',112728000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(57,2,'answer','trial/1/grade/grade','2031-07-23T16:44:38.365Z',114741000000,'{"value":1.5,"revision":2}');
INSERT INTO "event" VALUES(58,2,'answer','trial/1/fms/fms','2031-07-23T16:44:42.391Z',116754000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(59,2,'showing','trial/2','2031-07-23T16:44:46.417Z',118767000000,'{"showing":7,"presentation":1}');
INSERT INTO "event" VALUES(60,2,'shown','trial/2','2031-07-23T16:44:48.430Z',120780000000,'{"showing":7,"complete":true}');
INSERT INTO "event" VALUES(61,2,'answer','trial/2/grade/grade','2031-07-23T16:44:52.456Z',122793000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(62,2,'answer','trial/2/fms/fms','2031-07-23T16:44:56.482Z',124806000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(63,2,'finished','break/1','2031-07-23T16:44:58.495Z',126819000000,'{}');
INSERT INTO "event" VALUES(64,2,'showing','trial/3','2031-07-23T16:45:02.521Z',128832000000,'{"showing":8,"presentation":1}');
INSERT INTO "event" VALUES(65,2,'shown','trial/3','2031-07-23T16:45:04.534Z',130845000000,'{"showing":8,"complete":true}');
INSERT INTO "event" VALUES(66,2,'answer','trial/3/grade/grade','2031-07-23T16:45:08.560Z',132858000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(67,2,'answer','trial/3/fms/fms','2031-07-23T16:45:12.586Z',134871000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(68,2,'answer','after/vrsq/general_discomfort','2031-07-23T16:45:16.612Z',136884000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(69,2,'answer','after/vrsq/fatigue','2031-07-23T16:45:20.638Z',138897000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(70,2,'answer','after/vrsq/eyestrain','2031-07-23T16:45:24.664Z',140910000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(71,2,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:45:28.690Z',142923000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(72,2,'answer','after/vrsq/headache','2031-07-23T16:45:32.716Z',144936000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(73,2,'answer','after/vrsq/fullness_of_head','2031-07-23T16:45:36.742Z',146949000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(74,2,'answer','after/vrsq/blurred_vision','2031-07-23T16:45:40.768Z',148962000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(75,2,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:45:44.794Z',150975000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(76,2,'answer','after/vrsq/vertigo','2031-07-23T16:45:48.820Z',152988000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(77,2,'remark','trial/1','2031-07-23T16:45:50.833Z',155001000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(78,2,'end','','2031-07-23T16:45:52.846Z',157014000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(79,3,'begin','','2031-07-23T16:45:58.885Z',159027000000,'{"part":"main","row":4,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(80,3,'finished','consent','2031-07-23T16:46:00.898Z',161040000000,'{}');
INSERT INTO "event" VALUES(81,3,'answer','before/vrsq/general_discomfort','2031-07-23T16:46:04.924Z',163053000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(82,3,'answer','before/vrsq/fatigue','2031-07-23T16:46:08.950Z',165066000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(83,3,'answer','before/vrsq/eyestrain','2031-07-23T16:46:12.976Z',167079000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(84,3,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:46:17.002Z',169092000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(85,3,'answer','before/vrsq/headache','2031-07-23T16:46:21.028Z',171105000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(86,3,'answer','before/vrsq/fullness_of_head','2031-07-23T16:46:25.054Z',173118000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(87,3,'answer','before/vrsq/blurred_vision','2031-07-23T16:46:29.080Z',175131000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(88,3,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:46:33.106Z',177144000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(89,3,'answer','before/vrsq/vertigo','2031-07-23T16:46:37.132Z',179157000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(90,3,'showing','practice','2031-07-23T16:46:41.158Z',181170000000,'{"showing":9,"presentation":1}');
INSERT INTO "event" VALUES(91,3,'shown','practice','2031-07-23T16:46:43.171Z',183183000000,'{"showing":9,"complete":true}');
INSERT INTO "event" VALUES(92,3,'answer','practice/fms/fms','2031-07-23T16:46:47.197Z',185196000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(93,3,'showing','trial/1','2031-07-23T16:46:51.223Z',187209000000,'{"showing":10,"presentation":1}');
INSERT INTO "event" VALUES(94,3,'shown','trial/1','2031-07-23T16:46:53.236Z',189222000000,'{"showing":10,"complete":true}');
INSERT INTO "event" VALUES(95,3,'answer','trial/1/grade/grade','2031-07-23T16:46:57.262Z',191235000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(96,3,'answer','trial/1/grade/grade','2031-07-23T16:47:01.288Z',193248000000,'{"value":3.25,"revision":2}');
INSERT INTO "event" VALUES(97,3,'answer','trial/1/fms/fms','2031-07-23T16:47:05.314Z',195261000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(98,3,'showing','trial/2','2031-07-23T16:47:09.340Z',197274000000,'{"showing":11,"presentation":1}');
INSERT INTO "event" VALUES(99,3,'shown','trial/2','2031-07-23T16:47:11.353Z',199287000000,'{"showing":11,"complete":true}');
INSERT INTO "event" VALUES(100,3,'answer','trial/2/grade/grade','2031-07-23T16:47:15.379Z',201300000000,'{"value":5.5,"revision":1}');
INSERT INTO "event" VALUES(101,3,'answer','trial/2/fms/fms','2031-07-23T16:47:19.405Z',203313000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(102,3,'finished','break/1','2031-07-23T16:47:21.418Z',205326000000,'{}');
INSERT INTO "event" VALUES(103,3,'showing','trial/3','2031-07-23T16:47:25.444Z',207339000000,'{"showing":12,"presentation":1}');
INSERT INTO "event" VALUES(104,3,'shown','trial/3','2031-07-23T16:47:27.457Z',209352000000,'{"showing":12,"complete":true}');
INSERT INTO "event" VALUES(105,3,'answer','trial/3/grade/grade','2031-07-23T16:47:31.483Z',211365000000,'{"value":1.25,"revision":1}');
INSERT INTO "event" VALUES(106,3,'answer','trial/3/fms/fms','2031-07-23T16:47:35.509Z',213378000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(107,3,'answer','after/vrsq/general_discomfort','2031-07-23T16:47:39.535Z',215391000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(108,3,'answer','after/vrsq/fatigue','2031-07-23T16:47:43.561Z',217404000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(109,3,'answer','after/vrsq/eyestrain','2031-07-23T16:47:47.587Z',219417000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(110,3,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:47:51.613Z',221430000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(111,3,'answer','after/vrsq/headache','2031-07-23T16:47:55.639Z',223443000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(112,3,'answer','after/vrsq/fullness_of_head','2031-07-23T16:47:59.665Z',225456000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(113,3,'answer','after/vrsq/blurred_vision','2031-07-23T16:48:03.691Z',227469000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(114,3,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:48:07.717Z',229482000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(115,3,'answer','after/vrsq/vertigo','2031-07-23T16:48:11.743Z',231495000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(116,3,'remark','trial/1','2031-07-23T16:48:13.756Z',233508000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(117,3,'end','','2031-07-23T16:48:15.769Z',235521000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(118,4,'begin','','2031-07-23T16:48:21.808Z',237534000000,'{"part":"main","row":3,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(119,4,'finished','consent','2031-07-23T16:48:23.821Z',239547000000,'{}');
INSERT INTO "event" VALUES(120,4,'answer','before/vrsq/general_discomfort','2031-07-23T16:48:27.847Z',241560000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(121,4,'answer','before/vrsq/fatigue','2031-07-23T16:48:31.873Z',243573000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(122,4,'answer','before/vrsq/eyestrain','2031-07-23T16:48:35.899Z',245586000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(123,4,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:48:39.925Z',247599000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(124,4,'answer','before/vrsq/headache','2031-07-23T16:48:43.951Z',249612000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(125,4,'answer','before/vrsq/fullness_of_head','2031-07-23T16:48:47.977Z',251625000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(126,4,'answer','before/vrsq/blurred_vision','2031-07-23T16:48:52.003Z',253638000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(127,4,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:48:56.029Z',255651000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(128,4,'answer','before/vrsq/vertigo','2031-07-23T16:49:00.055Z',257664000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(129,4,'showing','practice','2031-07-23T16:49:04.081Z',259677000000,'{"showing":13,"presentation":1}');
INSERT INTO "event" VALUES(130,4,'shown','practice','2031-07-23T16:49:06.094Z',261690000000,'{"showing":13,"complete":true}');
INSERT INTO "event" VALUES(131,4,'answer','practice/fms/fms','2031-07-23T16:49:10.120Z',263703000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(132,4,'showing','trial/1','2031-07-23T16:49:14.146Z',265716000000,'{"showing":14,"presentation":1}');
INSERT INTO "event" VALUES(133,4,'shown','trial/1','2031-07-23T16:49:16.159Z',267729000000,'{"showing":14,"complete":false}');
INSERT INTO "event" VALUES(134,4,'showing','trial/1','2031-07-23T16:49:20.185Z',269742000000,'{"showing":15,"presentation":2}');
INSERT INTO "event" VALUES(135,4,'shown','trial/1','2031-07-23T16:49:22.198Z',271755000000,'{"showing":15,"complete":true}');
INSERT INTO "event" VALUES(136,4,'answer','trial/1/grade/grade','2031-07-23T16:49:26.224Z',273768000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(137,4,'answer','trial/1/grade/grade','2031-07-23T16:49:30.250Z',275781000000,'{"value":5.0,"revision":2}');
INSERT INTO "event" VALUES(138,4,'answer','trial/1/fms/fms','2031-07-23T16:49:34.276Z',277794000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(139,4,'showing','trial/2','2031-07-23T16:49:38.302Z',279807000000,'{"showing":16,"presentation":1}');
INSERT INTO "event" VALUES(140,4,'shown','trial/2','2031-07-23T16:49:40.315Z',281820000000,'{"showing":16,"complete":true}');
INSERT INTO "event" VALUES(141,4,'answer','trial/2/grade/grade','2031-07-23T16:49:44.341Z',283833000000,'{"value":1.25,"revision":1}');
INSERT INTO "event" VALUES(142,4,'answer','trial/2/fms/fms','2031-07-23T16:49:48.367Z',285846000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(143,4,'finished','break/1','2031-07-23T16:49:50.380Z',287859000000,'{}');
INSERT INTO "event" VALUES(144,4,'showing','trial/3','2031-07-23T16:49:54.406Z',289872000000,'{"showing":17,"presentation":1}');
INSERT INTO "event" VALUES(145,4,'shown','trial/3','2031-07-23T16:49:56.419Z',291885000000,'{"showing":17,"complete":true}');
INSERT INTO "event" VALUES(146,4,'answer','trial/3/grade/grade','2031-07-23T16:50:00.445Z',293898000000,'{"value":3.25,"revision":1}');
INSERT INTO "event" VALUES(147,4,'answer','trial/3/fms/fms','2031-07-23T16:50:04.471Z',295911000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(148,4,'answer','after/vrsq/general_discomfort','2031-07-23T16:50:08.497Z',297924000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(149,4,'answer','after/vrsq/fatigue','2031-07-23T16:50:12.523Z',299937000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(150,4,'answer','after/vrsq/eyestrain','2031-07-23T16:50:16.549Z',301950000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(151,4,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:50:20.575Z',303963000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(152,4,'answer','after/vrsq/headache','2031-07-23T16:50:24.601Z',305976000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(153,4,'answer','after/vrsq/fullness_of_head','2031-07-23T16:50:28.627Z',307989000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(154,4,'answer','after/vrsq/blurred_vision','2031-07-23T16:50:32.653Z',310002000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(155,4,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:50:36.679Z',312015000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(156,4,'answer','after/vrsq/vertigo','2031-07-23T16:50:40.705Z',314028000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(157,4,'remark','trial/1','2031-07-23T16:50:42.718Z',316041000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(158,4,'end','','2031-07-23T16:50:44.731Z',318054000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(159,5,'begin','','2031-07-23T16:50:50.770Z',320067000000,'{"part":"main","row":0,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(160,5,'finished','consent','2031-07-23T16:50:52.783Z',322080000000,'{}');
INSERT INTO "event" VALUES(161,5,'answer','before/vrsq/general_discomfort','2031-07-23T16:50:56.809Z',324093000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(162,5,'answer','before/vrsq/fatigue','2031-07-23T16:51:00.835Z',326106000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(163,5,'answer','before/vrsq/eyestrain','2031-07-23T16:51:04.861Z',328119000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(164,5,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:51:08.887Z',330132000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(165,5,'answer','before/vrsq/headache','2031-07-23T16:51:12.913Z',332145000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(166,5,'answer','before/vrsq/fullness_of_head','2031-07-23T16:51:16.939Z',334158000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(167,5,'answer','before/vrsq/blurred_vision','2031-07-23T16:51:20.965Z',336171000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(168,5,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:51:24.991Z',338184000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(169,5,'answer','before/vrsq/vertigo','2031-07-23T16:51:29.017Z',340197000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(170,5,'showing','practice','2031-07-23T16:51:33.043Z',342210000000,'{"showing":18,"presentation":1}');
INSERT INTO "event" VALUES(171,5,'shown','practice','2031-07-23T16:51:35.056Z',344223000000,'{"showing":18,"complete":true}');
INSERT INTO "event" VALUES(172,5,'answer','practice/fms/fms','2031-07-23T16:51:39.082Z',346236000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(173,5,'showing','trial/1','2031-07-23T16:51:43.108Z',348249000000,'{"showing":19,"presentation":1}');
INSERT INTO "event" VALUES(174,5,'shown','trial/1','2031-07-23T16:51:45.121Z',350262000000,'{"showing":19,"complete":true}');
INSERT INTO "event" VALUES(175,5,'answer','trial/1/grade/grade','2031-07-23T16:51:49.147Z',352275000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(176,5,'answer','trial/1/grade/grade','2031-07-23T16:51:53.173Z',354288000000,'{"value":2.75,"revision":2}');
INSERT INTO "event" VALUES(177,5,'answer','trial/1/fms/fms','2031-07-23T16:51:57.199Z',356301000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(178,5,'showing','trial/2','2031-07-23T16:52:01.225Z',358314000000,'{"showing":20,"presentation":1}');
INSERT INTO "event" VALUES(179,5,'shown','trial/2','2031-07-23T16:52:03.238Z',360327000000,'{"showing":20,"complete":true}');
INSERT INTO "event" VALUES(180,5,'answer','trial/2/grade/grade','2031-07-23T16:52:07.264Z',362340000000,'{"value":1.5,"revision":1}');
INSERT INTO "event" VALUES(181,5,'answer','trial/2/fms/fms','2031-07-23T16:52:11.290Z',364353000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(182,5,'finished','break/1','2031-07-23T16:52:13.303Z',366366000000,'{}');
INSERT INTO "event" VALUES(183,5,'showing','trial/3','2031-07-23T16:52:17.329Z',368379000000,'{"showing":21,"presentation":1}');
INSERT INTO "event" VALUES(184,5,'shown','trial/3','2031-07-23T16:52:19.342Z',370392000000,'{"showing":21,"complete":true}');
INSERT INTO "event" VALUES(185,5,'answer','trial/3/grade/grade','2031-07-23T16:52:23.368Z',372405000000,'{"value":5.5,"revision":1}');
INSERT INTO "event" VALUES(186,5,'answer','trial/3/fms/fms','2031-07-23T16:52:27.394Z',374418000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(187,5,'answer','after/vrsq/general_discomfort','2031-07-23T16:52:31.420Z',376431000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(188,5,'answer','after/vrsq/fatigue','2031-07-23T16:52:35.446Z',378444000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(189,5,'answer','after/vrsq/eyestrain','2031-07-23T16:52:39.472Z',380457000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(190,5,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:52:43.498Z',382470000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(191,5,'answer','after/vrsq/headache','2031-07-23T16:52:47.524Z',384483000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(192,5,'answer','after/vrsq/fullness_of_head','2031-07-23T16:52:51.550Z',386496000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(193,5,'answer','after/vrsq/blurred_vision','2031-07-23T16:52:55.576Z',388509000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(194,5,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:52:59.602Z',390522000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(195,5,'answer','after/vrsq/vertigo','2031-07-23T16:53:03.628Z',392535000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(196,5,'remark','trial/1','2031-07-23T16:53:05.641Z',394548000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(197,5,'end','','2031-07-23T16:53:07.654Z',396561000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(198,6,'begin','','2031-07-23T16:53:13.693Z',398574000000,'{"part":"main","row":1,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(199,6,'finished','consent','2031-07-23T16:53:15.706Z',400587000000,'{}');
INSERT INTO "event" VALUES(200,6,'answer','before/vrsq/general_discomfort','2031-07-23T16:53:19.732Z',402600000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(201,6,'answer','before/vrsq/fatigue','2031-07-23T16:53:23.758Z',404613000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(202,6,'answer','before/vrsq/eyestrain','2031-07-23T16:53:27.784Z',406626000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(203,6,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:53:31.810Z',408639000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(204,6,'answer','before/vrsq/headache','2031-07-23T16:53:35.836Z',410652000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(205,6,'answer','before/vrsq/fullness_of_head','2031-07-23T16:53:39.862Z',412665000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(206,6,'answer','before/vrsq/blurred_vision','2031-07-23T16:53:43.888Z',414678000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(207,6,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:53:47.914Z',416691000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(208,6,'answer','before/vrsq/vertigo','2031-07-23T16:53:51.940Z',418704000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(209,6,'showing','practice','2031-07-23T16:53:55.966Z',420717000000,'{"showing":22,"presentation":1}');
INSERT INTO "event" VALUES(210,6,'shown','practice','2031-07-23T16:53:57.979Z',422730000000,'{"showing":22,"complete":true}');
INSERT INTO "event" VALUES(211,6,'answer','practice/fms/fms','2031-07-23T16:54:02.005Z',424743000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(212,6,'showing','trial/1','2031-07-23T16:54:06.031Z',426756000000,'{"showing":23,"presentation":1}');
INSERT INTO "event" VALUES(213,6,'shown','trial/1','2031-07-23T16:54:08.044Z',428769000000,'{"showing":23,"complete":true}');
INSERT INTO "event" VALUES(214,6,'answer','trial/1/grade/grade','2031-07-23T16:54:12.070Z',430782000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(215,6,'answer','trial/1/grade/grade','2031-07-23T16:54:16.096Z',432795000000,'{"value":6.0,"revision":2}');
INSERT INTO "event" VALUES(216,6,'answer','trial/1/fms/fms','2031-07-23T16:54:20.122Z',434808000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(217,6,'showing','trial/2','2031-07-23T16:54:24.148Z',436821000000,'{"showing":24,"presentation":1}');
INSERT INTO "event" VALUES(218,6,'shown','trial/2','2031-07-23T16:54:26.161Z',438834000000,'{"showing":24,"complete":true}');
INSERT INTO "event" VALUES(219,6,'answer','trial/2/grade/grade','2031-07-23T16:54:30.187Z',440847000000,'{"value":4.5,"revision":1}');
INSERT INTO "event" VALUES(220,6,'answer','trial/2/fms/fms','2031-07-23T16:54:34.213Z',442860000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(221,6,'finished','break/1','2031-07-23T16:54:36.226Z',444873000000,'{}');
INSERT INTO "event" VALUES(222,6,'showing','trial/3','2031-07-23T16:54:40.252Z',446886000000,'{"showing":25,"presentation":1}');
INSERT INTO "event" VALUES(223,6,'shown','trial/3','2031-07-23T16:54:42.265Z',448899000000,'{"showing":25,"complete":true}');
INSERT INTO "event" VALUES(224,6,'answer','trial/3/grade/grade','2031-07-23T16:54:46.291Z',450912000000,'{"value":2.5,"revision":1}');
INSERT INTO "event" VALUES(225,6,'answer','trial/3/fms/fms','2031-07-23T16:54:50.317Z',452925000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(226,6,'answer','after/vrsq/general_discomfort','2031-07-23T16:54:54.343Z',454938000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(227,6,'answer','after/vrsq/fatigue','2031-07-23T16:54:58.369Z',456951000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(228,6,'answer','after/vrsq/eyestrain','2031-07-23T16:55:02.395Z',458964000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(229,6,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:55:06.421Z',460977000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(230,6,'answer','after/vrsq/headache','2031-07-23T16:55:10.447Z',462990000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(231,6,'answer','after/vrsq/fullness_of_head','2031-07-23T16:55:14.473Z',465003000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(232,6,'answer','after/vrsq/blurred_vision','2031-07-23T16:55:18.499Z',467016000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(233,6,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:55:22.525Z',469029000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(234,6,'answer','after/vrsq/vertigo','2031-07-23T16:55:26.551Z',471042000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(235,6,'remark','trial/1','2031-07-23T16:55:28.564Z',473055000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(236,6,'end','','2031-07-23T16:55:30.577Z',475068000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(237,7,'begin','','2031-07-23T16:55:36.616Z',477081000000,'{"part":"main","row":4,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(238,7,'finished','consent','2031-07-23T16:55:38.629Z',479094000000,'{}');
INSERT INTO "event" VALUES(239,7,'answer','before/vrsq/general_discomfort','2031-07-23T16:55:42.655Z',481107000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(240,7,'answer','before/vrsq/fatigue','2031-07-23T16:55:46.681Z',483120000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(241,7,'answer','before/vrsq/eyestrain','2031-07-23T16:55:50.707Z',485133000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(242,7,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:55:54.733Z',487146000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(243,7,'answer','before/vrsq/headache','2031-07-23T16:55:58.759Z',489159000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(244,7,'answer','before/vrsq/fullness_of_head','2031-07-23T16:56:02.785Z',491172000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(245,7,'answer','before/vrsq/blurred_vision','2031-07-23T16:56:06.811Z',493185000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(246,7,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:56:10.837Z',495198000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(247,7,'answer','before/vrsq/vertigo','2031-07-23T16:56:14.863Z',497211000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(248,7,'showing','practice','2031-07-23T16:56:18.889Z',499224000000,'{"showing":26,"presentation":1}');
INSERT INTO "event" VALUES(249,7,'shown','practice','2031-07-23T16:56:20.902Z',501237000000,'{"showing":26,"complete":true}');
INSERT INTO "event" VALUES(250,7,'answer','practice/fms/fms','2031-07-23T16:56:24.928Z',503250000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(251,7,'showing','trial/1','2031-07-23T16:56:28.954Z',505263000000,'{"showing":27,"presentation":1}');
INSERT INTO "event" VALUES(252,7,'shown','trial/1','2031-07-23T16:56:30.967Z',507276000000,'{"showing":27,"complete":true}');
INSERT INTO "event" VALUES(253,7,'answer','trial/1/grade/grade','2031-07-23T16:56:34.993Z',509289000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(254,7,'answer','trial/1/grade/grade','2031-07-23T16:56:39.019Z',511302000000,'{"value":3.25,"revision":2}');
INSERT INTO "event" VALUES(255,7,'answer','trial/1/fms/fms','2031-07-23T16:56:43.045Z',513315000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(256,7,'showing','trial/2','2031-07-23T16:56:47.071Z',515328000000,'{"showing":28,"presentation":1}');
INSERT INTO "event" VALUES(257,7,'shown','trial/2','2031-07-23T16:56:49.084Z',517341000000,'{"showing":28,"complete":true}');
INSERT INTO "event" VALUES(258,7,'answer','trial/2/grade/grade','2031-07-23T16:56:53.110Z',519354000000,'{"value":5.25,"revision":1}');
INSERT INTO "event" VALUES(259,7,'answer','trial/2/fms/fms','2031-07-23T16:56:57.136Z',521367000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(260,7,'finished','break/1','2031-07-23T16:56:59.149Z',523380000000,'{}');
INSERT INTO "event" VALUES(261,7,'showing','trial/3','2031-07-23T16:57:03.175Z',525393000000,'{"showing":29,"presentation":1}');
INSERT INTO "event" VALUES(262,7,'shown','trial/3','2031-07-23T16:57:05.188Z',527406000000,'{"showing":29,"complete":true}');
INSERT INTO "event" VALUES(263,7,'answer','trial/3/grade/grade','2031-07-23T16:57:09.214Z',529419000000,'{"value":1.75,"revision":1}');
INSERT INTO "event" VALUES(264,7,'answer','trial/3/fms/fms','2031-07-23T16:57:13.240Z',531432000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(265,7,'answer','after/vrsq/general_discomfort','2031-07-23T16:57:17.266Z',533445000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(266,7,'answer','after/vrsq/fatigue','2031-07-23T16:57:21.292Z',535458000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(267,7,'answer','after/vrsq/eyestrain','2031-07-23T16:57:25.318Z',537471000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(268,7,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:57:29.344Z',539484000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(269,7,'answer','after/vrsq/headache','2031-07-23T16:57:33.370Z',541497000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(270,7,'answer','after/vrsq/fullness_of_head','2031-07-23T16:57:37.396Z',543510000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(271,7,'answer','after/vrsq/blurred_vision','2031-07-23T16:57:41.422Z',545523000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(272,7,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:57:45.448Z',547536000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(273,7,'answer','after/vrsq/vertigo','2031-07-23T16:57:49.474Z',549549000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(274,7,'remark','trial/1','2031-07-23T16:57:51.487Z',551562000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(275,7,'end','','2031-07-23T16:57:53.500Z',553575000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(276,8,'begin','','2031-07-23T16:57:59.539Z',555588000000,'{"part":"main","row":2,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(277,8,'finished','consent','2031-07-23T16:58:01.552Z',557601000000,'{}');
INSERT INTO "event" VALUES(278,8,'answer','before/vrsq/general_discomfort','2031-07-23T16:58:05.578Z',559614000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(279,8,'answer','before/vrsq/fatigue','2031-07-23T16:58:09.604Z',561627000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(280,8,'answer','before/vrsq/eyestrain','2031-07-23T16:58:13.630Z',563640000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(281,8,'answer','before/vrsq/difficulty_focusing','2031-07-23T16:58:17.656Z',565653000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(282,8,'answer','before/vrsq/headache','2031-07-23T16:58:21.682Z',567666000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(283,8,'answer','before/vrsq/fullness_of_head','2031-07-23T16:58:25.708Z',569679000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(284,8,'answer','before/vrsq/blurred_vision','2031-07-23T16:58:29.734Z',571692000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(285,8,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T16:58:33.760Z',573705000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(286,8,'answer','before/vrsq/vertigo','2031-07-23T16:58:37.786Z',575718000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(287,8,'showing','practice','2031-07-23T16:58:41.812Z',577731000000,'{"showing":30,"presentation":1}');
INSERT INTO "event" VALUES(288,8,'shown','practice','2031-07-23T16:58:43.825Z',579744000000,'{"showing":30,"complete":true}');
INSERT INTO "event" VALUES(289,8,'answer','practice/fms/fms','2031-07-23T16:58:47.851Z',581757000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(290,8,'showing','trial/1','2031-07-23T16:58:51.877Z',583770000000,'{"showing":31,"presentation":1}');
INSERT INTO "event" VALUES(291,8,'shown','trial/1','2031-07-23T16:58:53.890Z',585783000000,'{"showing":31,"complete":true}');
INSERT INTO "event" VALUES(292,8,'answer','trial/1/grade/grade','2031-07-23T16:58:57.916Z',587796000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(293,8,'answer','trial/1/grade/grade','2031-07-23T16:59:01.942Z',589809000000,'{"value":5.5,"revision":2}');
INSERT INTO "event" VALUES(294,8,'answer','trial/1/fms/fms','2031-07-23T16:59:05.968Z',591822000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(295,8,'showing','trial/2','2031-07-23T16:59:09.994Z',593835000000,'{"showing":32,"presentation":1}');
INSERT INTO "event" VALUES(296,8,'shown','trial/2','2031-07-23T16:59:12.007Z',595848000000,'{"showing":32,"complete":true}');
INSERT INTO "event" VALUES(297,8,'answer','trial/2/grade/grade','2031-07-23T16:59:16.033Z',597861000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(298,8,'answer','trial/2/fms/fms','2031-07-23T16:59:20.059Z',599874000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(299,8,'finished','break/1','2031-07-23T16:59:22.072Z',601887000000,'{}');
INSERT INTO "event" VALUES(300,8,'showing','trial/3','2031-07-23T16:59:26.098Z',603900000000,'{"showing":33,"presentation":1}');
INSERT INTO "event" VALUES(301,8,'shown','trial/3','2031-07-23T16:59:28.111Z',605913000000,'{"showing":33,"complete":true}');
INSERT INTO "event" VALUES(302,8,'answer','trial/3/grade/grade','2031-07-23T16:59:32.137Z',607926000000,'{"value":1.75,"revision":1}');
INSERT INTO "event" VALUES(303,8,'answer','trial/3/fms/fms','2031-07-23T16:59:36.163Z',609939000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(304,8,'answer','after/vrsq/general_discomfort','2031-07-23T16:59:40.189Z',611952000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(305,8,'answer','after/vrsq/fatigue','2031-07-23T16:59:44.215Z',613965000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(306,8,'answer','after/vrsq/eyestrain','2031-07-23T16:59:48.241Z',615978000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(307,8,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:59:52.267Z',617991000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(308,8,'answer','after/vrsq/headache','2031-07-23T16:59:56.293Z',620004000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(309,8,'answer','after/vrsq/fullness_of_head','2031-07-23T17:00:00.319Z',622017000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(310,8,'answer','after/vrsq/blurred_vision','2031-07-23T17:00:04.345Z',624030000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(311,8,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T17:00:08.371Z',626043000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(312,8,'answer','after/vrsq/vertigo','2031-07-23T17:00:12.397Z',628056000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(313,8,'remark','trial/1','2031-07-23T17:00:14.410Z',630069000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(314,8,'end','','2031-07-23T17:00:16.423Z',632082000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(315,9,'begin','','2031-07-23T17:00:22.462Z',634095000000,'{"part":"main","row":5,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(316,9,'finished','consent','2031-07-23T17:00:24.475Z',636108000000,'{}');
INSERT INTO "event" VALUES(317,9,'answer','before/vrsq/general_discomfort','2031-07-23T17:00:28.501Z',638121000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(318,9,'answer','before/vrsq/fatigue','2031-07-23T17:00:32.527Z',640134000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(319,9,'answer','before/vrsq/eyestrain','2031-07-23T17:00:36.553Z',642147000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(320,9,'answer','before/vrsq/difficulty_focusing','2031-07-23T17:00:40.579Z',644160000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(321,9,'answer','before/vrsq/headache','2031-07-23T17:00:44.605Z',646173000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(322,9,'answer','before/vrsq/fullness_of_head','2031-07-23T17:00:48.631Z',648186000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(323,9,'answer','before/vrsq/blurred_vision','2031-07-23T17:00:52.657Z',650199000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(324,9,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T17:00:56.683Z',652212000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(325,9,'answer','before/vrsq/vertigo','2031-07-23T17:01:00.709Z',654225000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(326,9,'showing','practice','2031-07-23T17:01:04.735Z',656238000000,'{"showing":34,"presentation":1}');
INSERT INTO "event" VALUES(327,9,'shown','practice','2031-07-23T17:01:06.748Z',658251000000,'{"showing":34,"complete":true}');
INSERT INTO "event" VALUES(328,9,'answer','practice/fms/fms','2031-07-23T17:01:10.774Z',660264000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(329,9,'showing','trial/1','2031-07-23T17:01:14.800Z',662277000000,'{"showing":35,"presentation":1}');
INSERT INTO "event" VALUES(330,9,'shown','trial/1','2031-07-23T17:01:16.813Z',664290000000,'{"showing":35,"complete":true}');
INSERT INTO "event" VALUES(331,9,'answer','trial/1/grade/grade','2031-07-23T17:01:20.839Z',666303000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(332,9,'answer','trial/1/grade/grade','2031-07-23T17:01:24.865Z',668316000000,'{"value":1.25,"revision":2}');
INSERT INTO "event" VALUES(333,9,'answer','trial/1/fms/fms','2031-07-23T17:01:28.891Z',670329000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(334,9,'remark','trial/1','2031-07-23T17:01:30.904Z',672342000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(335,9,'end','','2031-07-23T17:01:32.917Z',674355000000,'{"status":"stopped","why":"asked for"}');
INSERT INTO "event" VALUES(336,10,'begin','','2031-07-23T17:01:38.956Z',676368000000,'{"part":"main","row":5,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(337,10,'finished','consent','2031-07-23T17:01:40.969Z',678381000000,'{}');
INSERT INTO "event" VALUES(338,10,'answer','before/vrsq/general_discomfort','2031-07-23T17:01:44.995Z',680394000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(339,10,'answer','before/vrsq/fatigue','2031-07-23T17:01:49.021Z',682407000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(340,10,'answer','before/vrsq/eyestrain','2031-07-23T17:01:53.047Z',684420000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(341,10,'answer','before/vrsq/difficulty_focusing','2031-07-23T17:01:57.073Z',686433000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(342,10,'answer','before/vrsq/headache','2031-07-23T17:02:01.099Z',688446000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(343,10,'answer','before/vrsq/fullness_of_head','2031-07-23T17:02:05.125Z',690459000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(344,10,'answer','before/vrsq/blurred_vision','2031-07-23T17:02:09.151Z',692472000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(345,10,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T17:02:13.177Z',694485000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(346,10,'answer','before/vrsq/vertigo','2031-07-23T17:02:17.203Z',696498000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(347,10,'showing','practice','2031-07-23T17:02:21.229Z',698511000000,'{"showing":36,"presentation":1}');
INSERT INTO "event" VALUES(348,10,'shown','practice','2031-07-23T17:02:23.242Z',700524000000,'{"showing":36,"complete":true}');
INSERT INTO "event" VALUES(349,10,'answer','practice/fms/fms','2031-07-23T17:02:27.268Z',702537000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(350,10,'showing','trial/1','2031-07-23T17:02:31.294Z',704550000000,'{"showing":37,"presentation":1}');
INSERT INTO "event" VALUES(351,10,'shown','trial/1','2031-07-23T17:02:33.307Z',706563000000,'{"showing":37,"complete":true}');
INSERT INTO "event" VALUES(352,10,'answer','trial/1/grade/grade','2031-07-23T17:02:37.333Z',708576000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(353,10,'answer','trial/1/grade/grade','2031-07-23T17:02:41.359Z',710589000000,'{"value":2.0,"revision":2}');
INSERT INTO "event" VALUES(354,10,'answer','trial/1/fms/fms','2031-07-23T17:02:45.385Z',712602000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(355,10,'showing','trial/2','2031-07-23T17:02:49.411Z',714615000000,'{"showing":38,"presentation":1}');
INSERT INTO "event" VALUES(356,10,'shown','trial/2','2031-07-23T17:02:51.424Z',716628000000,'{"showing":38,"complete":true}');
INSERT INTO "event" VALUES(357,10,'answer','trial/2/grade/grade','2031-07-23T17:02:55.450Z',718641000000,'{"value":3.25,"revision":1}');
INSERT INTO "event" VALUES(358,10,'answer','trial/2/fms/fms','2031-07-23T17:02:59.476Z',720654000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(359,10,'finished','break/1','2031-07-23T17:03:01.489Z',722667000000,'{}');
INSERT INTO "event" VALUES(360,10,'remark','trial/1','2031-07-23T17:03:03.502Z',724680000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(361,10,'end','','2031-07-23T17:03:05.515Z',726693000000,'{"status":"sick","why":"asked for"}');
INSERT INTO "event" VALUES(362,11,'begin','','2031-07-23T17:03:11.554Z',728706000000,'{"part":"main","row":5,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(363,11,'refused','consent','2031-07-23T17:03:13.567Z',730719000000,'{"by":"participant"}');
INSERT INTO "event" VALUES(364,11,'remark','trial/1','2031-07-23T17:03:15.580Z',732732000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(365,11,'end','','2031-07-23T17:03:17.593Z',734745000000,'{"status":"declined","why":"asked for"}');
INSERT INTO "event" VALUES(366,12,'begin','','2031-07-23T17:03:23.632Z',736758000000,'{"part":"main","row":5,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(367,12,'finished','consent','2031-07-23T17:03:25.645Z',738771000000,'{}');
INSERT INTO "event" VALUES(368,12,'answer','before/vrsq/general_discomfort','2031-07-23T17:03:29.671Z',740784000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(369,12,'answer','before/vrsq/fatigue','2031-07-23T17:03:33.697Z',742797000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(370,12,'answer','before/vrsq/eyestrain','2031-07-23T17:03:37.723Z',744810000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(371,12,'answer','before/vrsq/difficulty_focusing','2031-07-23T17:03:41.749Z',746823000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(372,12,'answer','before/vrsq/headache','2031-07-23T17:03:45.775Z',748836000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(373,12,'answer','before/vrsq/fullness_of_head','2031-07-23T17:03:49.801Z',750849000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(374,12,'answer','before/vrsq/blurred_vision','2031-07-23T17:03:53.827Z',752862000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(375,12,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T17:03:57.853Z',754875000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(376,12,'answer','before/vrsq/vertigo','2031-07-23T17:04:01.879Z',756888000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(377,12,'showing','practice','2031-07-23T17:04:05.905Z',758901000000,'{"showing":39,"presentation":1}');
INSERT INTO "event" VALUES(378,12,'shown','practice','2031-07-23T17:04:07.918Z',760914000000,'{"showing":39,"complete":true}');
INSERT INTO "event" VALUES(379,12,'answer','practice/fms/fms','2031-07-23T17:04:11.944Z',762927000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(380,12,'showing','trial/1','2031-07-23T17:04:15.970Z',764940000000,'{"showing":40,"presentation":1}');
INSERT INTO "event" VALUES(381,12,'shown','trial/1','2031-07-23T17:04:17.983Z',766953000000,'{"showing":40,"complete":true}');
INSERT INTO "event" VALUES(382,12,'answer','trial/1/grade/grade','2031-07-23T17:04:22.009Z',768966000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(383,12,'answer','trial/1/grade/grade','2031-07-23T17:04:26.035Z',770979000000,'{"value":1.25,"revision":2}');
INSERT INTO "event" VALUES(384,12,'answer','trial/1/fms/fms','2031-07-23T17:04:30.061Z',772992000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(385,12,'showing','trial/2','2031-07-23T17:04:34.087Z',775005000000,'{"showing":41,"presentation":1}');
INSERT INTO "event" VALUES(386,12,'shown','trial/2','2031-07-23T17:04:36.100Z',777018000000,'{"showing":41,"complete":true}');
INSERT INTO "event" VALUES(387,12,'answer','trial/2/grade/grade','2031-07-23T17:04:40.126Z',779031000000,'{"value":3.25,"revision":1}');
INSERT INTO "event" VALUES(388,12,'answer','trial/2/fms/fms','2031-07-23T17:04:44.152Z',781044000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(389,12,'finished','break/1','2031-07-23T17:04:46.165Z',783057000000,'{}');
INSERT INTO "event" VALUES(390,12,'remark','trial/1','2031-07-23T17:04:48.178Z',785070000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(391,12,'end','','2031-07-23T17:04:50.191Z',787083000000,'{"status":"interrupted","why":"asked for"}');
INSERT INTO "event" VALUES(392,13,'begin','','2031-07-23T17:04:56.230Z',789096000000,'{"part":"main","row":2,"plan_text_changed":false,"consent_version":"2","consent_sha256":"6add97f6ccc214fd385612076194a5f1696d11449f006f33199ccaae20a0d16c"}');
INSERT INTO "event" VALUES(393,13,'finished','consent','2031-07-23T17:04:58.243Z',791109000000,'{}');
INSERT INTO "event" VALUES(394,13,'answer','before/vrsq/general_discomfort','2031-07-23T17:05:02.269Z',793122000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(395,13,'answer','before/vrsq/fatigue','2031-07-23T17:05:06.295Z',795135000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(396,13,'answer','before/vrsq/eyestrain','2031-07-23T17:05:10.321Z',797148000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(397,13,'answer','before/vrsq/difficulty_focusing','2031-07-23T17:05:14.347Z',799161000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(398,13,'answer','before/vrsq/headache','2031-07-23T17:05:18.373Z',801174000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(399,13,'answer','before/vrsq/fullness_of_head','2031-07-23T17:05:22.399Z',803187000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(400,13,'answer','before/vrsq/blurred_vision','2031-07-23T17:05:26.425Z',805200000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(401,13,'answer','before/vrsq/dizzy_eyes_closed','2031-07-23T17:05:30.451Z',807213000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(402,13,'answer','before/vrsq/vertigo','2031-07-23T17:05:34.477Z',809226000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(403,13,'showing','practice','2031-07-23T17:05:38.503Z',811239000000,'{"showing":42,"presentation":1}');
INSERT INTO "event" VALUES(404,13,'shown','practice','2031-07-23T17:05:40.516Z',813252000000,'{"showing":42,"complete":true}');
INSERT INTO "event" VALUES(405,13,'answer','practice/fms/fms','2031-07-23T17:05:44.542Z',815265000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(406,13,'showing','trial/1','2031-07-23T17:05:48.568Z',817278000000,'{"showing":43,"presentation":1}');
INSERT INTO "event" VALUES(407,13,'shown','trial/1','2031-07-23T17:05:50.581Z',819291000000,'{"showing":43,"complete":true}');
INSERT INTO "event" VALUES(408,13,'answer','trial/1/grade/grade','2031-07-23T17:05:54.607Z',821304000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(409,13,'answer','trial/1/grade/grade','2031-07-23T17:05:58.633Z',823317000000,'{"value":5.5,"revision":2}');
INSERT INTO "event" VALUES(410,13,'answer','trial/1/fms/fms','2031-07-23T17:06:02.659Z',825330000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(411,13,'showing','trial/2','2031-07-23T17:06:06.685Z',827343000000,'{"showing":44,"presentation":1}');
INSERT INTO "event" VALUES(412,13,'shown','trial/2','2031-07-23T17:06:08.698Z',829356000000,'{"showing":44,"complete":true}');
INSERT INTO "event" VALUES(413,13,'answer','trial/2/grade/grade','2031-07-23T17:06:12.724Z',831369000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(414,13,'answer','trial/2/fms/fms','2031-07-23T17:06:16.750Z',833382000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(415,13,'finished','break/1','2031-07-23T17:06:18.763Z',835395000000,'{}');
INSERT INTO "event" VALUES(416,13,'showing','trial/3','2031-07-23T17:06:22.789Z',837408000000,'{"showing":45,"presentation":1}');
INSERT INTO "event" VALUES(417,13,'shown','trial/3','2031-07-23T17:06:24.802Z',839421000000,'{"showing":45,"complete":true}');
INSERT INTO "event" VALUES(418,13,'answer','trial/3/grade/grade','2031-07-23T17:06:28.828Z',841434000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(419,13,'answer','trial/3/fms/fms','2031-07-23T17:06:32.854Z',843447000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(420,13,'answer','after/vrsq/general_discomfort','2031-07-23T17:06:36.880Z',845460000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(421,13,'answer','after/vrsq/fatigue','2031-07-23T17:06:40.906Z',847473000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(422,13,'answer','after/vrsq/eyestrain','2031-07-23T17:06:44.932Z',849486000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(423,13,'answer','after/vrsq/difficulty_focusing','2031-07-23T17:06:48.958Z',851499000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(424,13,'answer','after/vrsq/headache','2031-07-23T17:06:52.984Z',853512000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(425,13,'answer','after/vrsq/fullness_of_head','2031-07-23T17:06:57.010Z',855525000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(426,13,'answer','after/vrsq/blurred_vision','2031-07-23T17:07:01.036Z',857538000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(427,13,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T17:07:05.062Z',859551000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(428,13,'answer','after/vrsq/vertigo','2031-07-23T17:07:09.088Z',861564000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(429,13,'remark','trial/1','2031-07-23T17:07:11.101Z',863577000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(430,13,'end','','2031-07-23T17:07:13.114Z',865590000000,'{"status":"complete","why":""}');
CREATE TABLE participant (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE COLLATE NOCASE,
  sub TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('person', 'pilot', 'simulated')),
  withdrawing INTEGER NOT NULL DEFAULT 0
) STRICT;
INSERT INTO "participant" VALUES(1,'P0','ptgz4jfebz9s','person',0);
INSERT INTO "participant" VALUES(2,'P1','do78xrlgqnbq','person',0);
INSERT INTO "participant" VALUES(3,'P2','rmktsxfvy6pl','person',0);
INSERT INTO "participant" VALUES(4,'P3','p4rf9tast6m0','person',0);
INSERT INTO "participant" VALUES(5,'P4','1s12kotqcfc3','person',0);
INSERT INTO "participant" VALUES(6,'P5','r784vjme0m2r','person',0);
INSERT INTO "participant" VALUES(7,'P6','lw1u9mugdorp','person',0);
INSERT INTO "participant" VALUES(8,'P7','hvls3bcwfsub','person',0);
INSERT INTO "participant" VALUES(9,'stopped','usuj0esm2siq','person',0);
INSERT INTO "participant" VALUES(10,'ill','ykvaxc3kxxsg','person',0);
INSERT INTO "participant" VALUES(11,'no','2n1nhdddkjc8','person',0);
INSERT INTO "participant" VALUES(12,'cut','5puch7s0m4mp','person',0);
INSERT INTO "participant" VALUES(13,'try','205co02p1n5m','pilot',0);
CREATE TABLE plan (id INTEGER PRIMARY KEY, text TEXT NOT NULL, meaning TEXT NOT NULL, UNIQUE (text, meaning)) STRICT;
INSERT INTO "plan" VALUES(1,'
schema = 1
name = "late-or-warped"
title = "Does a warp help?"
seed = 3
[common]
scene = "planes"
[trial]
seconds = 1
scales = ["grade"]
[practice]
seconds = 1
[sickness]
scale = "fms"
[questionnaires]
before = ["vrsq"]
after = ["vrsq"]
[consent]
version = "2"
text = "You may stop."
[breaks]
every = 2
seconds = 1
[[condition]]
name = "late"
latency = 400
warp = "none"
fill = "none"
[[condition]]
name = "warped"
latency = 400
warp = "forward"
guard = 1.5
[[condition]]
name = "reference"
latency = 0
warp = "none"
fill = "none"
reference = true
[[family]]
name = "the warp"
pairs = [["late", "warped"]]
','{"conditions":[{"name":"late","settings":{"fill":"none","latency":400,"scene":"planes","warp":"none"},"reference":false},{"name":"warped","settings":{"guard":1.5,"latency":400,"scene":"planes","warp":"forward"},"reference":false},{"name":"reference","settings":{"fill":"none","latency":0,"scene":"planes","warp":"none"},"reference":true}],"seconds":1.0,"repeats":1,"order":"williams","seed":3,"scales":[{"name":"grade","asked":["",["grade","How good was that, all in all?"]],"range":[1.0,6.0,0.25],"anchors":{"1":"very good","2":"good","3":"satisfactory","4":"sufficient","5":"poor","6":"insufficient"},"low_is_good":true}],"practice":[{"name":"practice","settings":{"fill":"none","latency":0,"scene":"planes","warp":"none"},"reference":false},1.0],"sickness":{"scale":{"name":"fms","asked":["",["fms","How sick do you feel now? Think of nausea, general discomfort and stomach problems."]],"range":[0.0,20.0,1.0],"anchors":{"0":"no sickness at all","20":"frank sickness"},"low_is_good":true},"every":1,"stop_at":null,"rise":null},"before":[{"name":"vrsq","asked":["How much does this affect you right now?",["general_discomfort","General discomfort"],["fatigue","Fatigue"],["eyestrain","Eyestrain"],["difficulty_focusing","Difficulty focusing"],["headache","Headache"],["fullness_of_head","Fullness of head"],["blurred_vision","Blurred vision"],["dizzy_eyes_closed","Dizzy (eyes closed)"],["vertigo","Vertigo"]],"range":[0.0,3.0,1.0],"anchors":{"0":"none","1":"slight","2":"moderate","3":"severe"},"low_is_good":true}],"after":[{"name":"vrsq","asked":["How much does this affect you right now?",["general_discomfort","General discomfort"],["fatigue","Fatigue"],["eyestrain","Eyestrain"],["difficulty_focusing","Difficulty focusing"],["headache","Headache"],["fullness_of_head","Fullness of head"],["blurred_vision","Blurred vision"],["dizzy_eyes_closed","Dizzy (eyes closed)"],["vertigo","Vertigo"]],"range":[0.0,3.0,1.0],"anchors":{"0":"none","1":"slight","2":"moderate","3":"severe"},"low_is_good":true}]}');
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
INSERT INTO "session" VALUES(1,1,1,'main',2,'[["late","warped","reference"]]',1,'complete','','2031-07-23T16:41:11.026Z','2031-07-23T16:43:31.936Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(2,2,1,'main',5,'[["reference","warped","late"]]',1,'complete','','2031-07-23T16:43:33.949Z','2031-07-23T16:45:54.859Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(3,3,1,'main',4,'[["warped","late","reference"]]',1,'complete','','2031-07-23T16:45:56.872Z','2031-07-23T16:48:17.782Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-P2.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(4,4,1,'main',3,'[["late","reference","warped"]]',1,'complete','','2031-07-23T16:48:19.795Z','2031-07-23T16:50:46.744Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(5,5,1,'main',0,'[["warped","reference","late"]]',1,'complete','','2031-07-23T16:50:48.757Z','2031-07-23T16:53:09.667Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(6,6,1,'main',1,'[["reference","late","warped"]]',1,'complete','','2031-07-23T16:53:11.680Z','2031-07-23T16:55:32.590Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-P5.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(7,7,1,'main',4,'[["warped","late","reference"]]',1,'complete','','2031-07-23T16:55:34.603Z','2031-07-23T16:57:55.513Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(8,8,1,'main',2,'[["late","warped","reference"]]',1,'complete','','2031-07-23T16:57:57.526Z','2031-07-23T17:00:18.436Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(9,9,1,'main',5,'[["reference","warped","late"]]',1,'stopped','asked for','2031-07-23T17:00:20.449Z','2031-07-23T17:01:34.930Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-stopped.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(10,10,1,'main',5,'[["reference","warped","late"]]',1,'sick','asked for','2031-07-23T17:01:36.943Z','2031-07-23T17:03:07.528Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(11,11,1,'main',5,'[["reference","warped","late"]]',1,'stopped','asked for','2031-07-23T17:03:09.541Z','2031-07-23T17:03:19.606Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(12,12,1,'main',5,'[["reference","warped","late"]]',1,'interrupted','asked for','2031-07-23T17:03:21.619Z','2031-07-23T17:04:52.204Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(13,13,1,'main',2,'[["late","warped","reference"]]',1,'complete','','2031-07-23T17:04:54.217Z','2031-07-23T17:07:15.127Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-try.csv","trace_axes":"unity, assumed"}');
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
INSERT INTO "showing" VALUES(1,1,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','ptgz4jfebz9s_ses-1_trial-0_1.csv','{"latency_ms_median":401.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:41:53.299Z');
INSERT INTO "showing" VALUES(2,1,'trial/1',1,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','ptgz4jfebz9s_ses-1_trial-1_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:03.364Z');
INSERT INTO "showing" VALUES(3,1,'trial/2',2,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','ptgz4jfebz9s_ses-1_trial-2_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:21.481Z');
INSERT INTO "showing" VALUES(4,1,'trial/3',3,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','ptgz4jfebz9s_ses-1_trial-3_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:37.585Z');
INSERT INTO "showing" VALUES(5,2,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','do78xrlgqnbq_ses-1_trial-0_1.csv','{"latency_ms_median":402.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:44:16.222Z');
INSERT INTO "showing" VALUES(6,2,'trial/1',1,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','do78xrlgqnbq_ses-1_trial-1_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:44:26.287Z');
INSERT INTO "showing" VALUES(7,2,'trial/2',2,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','do78xrlgqnbq_ses-1_trial-2_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:44:44.404Z');
INSERT INTO "showing" VALUES(8,2,'trial/3',3,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','do78xrlgqnbq_ses-1_trial-3_1.csv','{"latency_ms_median":423.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:00.508Z');
INSERT INTO "showing" VALUES(9,3,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','rmktsxfvy6pl_ses-1_trial-0_1.csv','{"latency_ms_median":403.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:46:39.145Z');
INSERT INTO "showing" VALUES(10,3,'trial/1',1,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','rmktsxfvy6pl_ses-1_trial-1_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:49.210Z');
INSERT INTO "showing" VALUES(11,3,'trial/2',2,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','rmktsxfvy6pl_ses-1_trial-2_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:47:07.327Z');
INSERT INTO "showing" VALUES(12,3,'trial/3',3,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','rmktsxfvy6pl_ses-1_trial-3_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:47:23.431Z');
INSERT INTO "showing" VALUES(13,4,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','p4rf9tast6m0_ses-1_trial-0_1.csv','{"latency_ms_median":404.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:49:02.068Z');
INSERT INTO "showing" VALUES(14,4,'trial/1',1,1,'late',1,0,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','p4rf9tast6m0_ses-1_trial-1_1.csv','{}','{}','2031-07-23T16:49:12.133Z');
INSERT INTO "showing" VALUES(15,4,'trial/1',1,1,'late',2,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','p4rf9tast6m0_ses-1_trial-1_2.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:18.172Z');
INSERT INTO "showing" VALUES(16,4,'trial/2',2,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','p4rf9tast6m0_ses-1_trial-2_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:36.289Z');
INSERT INTO "showing" VALUES(17,4,'trial/3',3,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','p4rf9tast6m0_ses-1_trial-3_1.csv','{"latency_ms_median":425.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:52.393Z');
INSERT INTO "showing" VALUES(18,5,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','1s12kotqcfc3_ses-1_trial-0_1.csv','{"latency_ms_median":405.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120","onset_s":12.5}','{}','2031-07-23T16:51:31.030Z');
INSERT INTO "showing" VALUES(19,5,'trial/1',1,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','1s12kotqcfc3_ses-1_trial-1_1.csv','{"latency_ms_median":412.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120","onset_s":13.5}','{"psnr_db":28.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:51:41.095Z');
INSERT INTO "showing" VALUES(20,5,'trial/2',2,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','1s12kotqcfc3_ses-1_trial-2_1.csv','{"latency_ms_median":419.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120","onset_s":14.5}','{"psnr_db":27.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:51:59.212Z');
INSERT INTO "showing" VALUES(21,5,'trial/3',3,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','1s12kotqcfc3_ses-1_trial-3_1.csv','{"latency_ms_median":426.5,"latency_ms_sd":5.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120","onset_s":15.5}','{"psnr_db":26.6,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:52:15.316Z');
INSERT INTO "showing" VALUES(22,6,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','r784vjme0m2r_ses-1_trial-0_1.csv','{"latency_ms_median":406.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:53:53.953Z');
INSERT INTO "showing" VALUES(23,6,'trial/1',1,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','r784vjme0m2r_ses-1_trial-1_1.csv','{"latency_ms_median":413.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:54:04.018Z');
INSERT INTO "showing" VALUES(24,6,'trial/2',2,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','r784vjme0m2r_ses-1_trial-2_1.csv','{"latency_ms_median":420.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:54:22.135Z');
INSERT INTO "showing" VALUES(25,6,'trial/3',3,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','r784vjme0m2r_ses-1_trial-3_1.csv','{"latency_ms_median":427.5,"latency_ms_sd":6.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.5,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:54:38.239Z');
INSERT INTO "showing" VALUES(26,7,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','lw1u9mugdorp_ses-1_trial-0_1.csv','{"latency_ms_median":407.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:56:16.876Z');
INSERT INTO "showing" VALUES(27,7,'trial/1',1,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','lw1u9mugdorp_ses-1_trial-1_1.csv','{"latency_ms_median":414.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:26.941Z');
INSERT INTO "showing" VALUES(28,7,'trial/2',2,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','lw1u9mugdorp_ses-1_trial-2_1.csv','{"latency_ms_median":421.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:56:45.058Z');
INSERT INTO "showing" VALUES(29,7,'trial/3',3,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','lw1u9mugdorp_ses-1_trial-3_1.csv','{"latency_ms_median":428.5,"latency_ms_sd":7.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.6000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.4,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:57:01.162Z');
INSERT INTO "showing" VALUES(30,8,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','hvls3bcwfsub_ses-1_trial-0_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":8.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:58:39.799Z');
INSERT INTO "showing" VALUES(31,8,'trial/1',1,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','hvls3bcwfsub_ses-1_trial-1_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":8.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.3,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:58:49.864Z');
INSERT INTO "showing" VALUES(32,8,'trial/2',2,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','hvls3bcwfsub_ses-1_trial-2_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":8.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.9,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.3,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:07.981Z');
INSERT INTO "showing" VALUES(33,8,'trial/3',3,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','hvls3bcwfsub_ses-1_trial-3_1.csv','{"latency_ms_median":429.5,"latency_ms_sd":8.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.7000000000000001,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.3,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:59:24.085Z');
INSERT INTO "showing" VALUES(34,9,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','usuj0esm2siq_ses-1_trial-0_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":9.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.8,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T17:01:02.722Z');
INSERT INTO "showing" VALUES(35,9,'trial/1',1,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','usuj0esm2siq_ses-1_trial-1_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":9.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.9,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.2,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:01:12.787Z');
INSERT INTO "showing" VALUES(36,10,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','ykvaxc3kxxsg_ses-1_trial-0_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.9,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T17:02:19.216Z');
INSERT INTO "showing" VALUES(37,10,'trial/1',1,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','ykvaxc3kxxsg_ses-1_trial-1_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:29.281Z');
INSERT INTO "showing" VALUES(38,10,'trial/2',2,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','ykvaxc3kxxsg_ses-1_trial-2_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":10.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.1,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.1,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:02:47.398Z');
INSERT INTO "showing" VALUES(39,12,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','5puch7s0m4mp_ses-1_trial-0_1.csv','{"latency_ms_median":413.5,"latency_ms_sd":13.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.2000000000000002,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T17:04:03.892Z');
INSERT INTO "showing" VALUES(40,12,'trial/1',1,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','5puch7s0m4mp_ses-1_trial-1_1.csv','{"latency_ms_median":420.5,"latency_ms_sd":13.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.3,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:04:13.957Z');
INSERT INTO "showing" VALUES(41,12,'trial/2',2,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','5puch7s0m4mp_ses-1_trial-2_1.csv','{"latency_ms_median":427.5,"latency_ms_sd":13.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.4000000000000001,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:04:32.074Z');
INSERT INTO "showing" VALUES(42,13,'practice',0,1,'practice',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','205co02p1n5m_ses-1_trial-0_1.csv','{"latency_ms_median":412.5,"latency_ms_sd":12.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.1,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T17:05:36.490Z');
INSERT INTO "showing" VALUES(43,13,'trial/1',1,1,'late',1,1,'{"scene":"planes","latency":400,"warp":"none","fill":"none"}','205co02p1n5m_ses-1_trial-1_1.csv','{"latency_ms_median":419.5,"latency_ms_sd":12.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.2000000000000002,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:05:46.555Z');
INSERT INTO "showing" VALUES(44,13,'trial/2',2,1,'warped',1,1,'{"scene":"planes","latency":400,"warp":"forward","guard":1.5}','205co02p1n5m_ses-1_trial-2_1.csv','{"latency_ms_median":426.5,"latency_ms_sd":12.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.3,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:06:04.672Z');
INSERT INTO "showing" VALUES(45,13,'trial/3',3,1,'reference',1,1,'{"scene":"planes","latency":0,"warp":"none","fill":"none"}','205co02p1n5m_ses-1_trial-3_1.csv','{"latency_ms_median":433.5,"latency_ms_sd":12.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":1.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":25.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T17:06:20.776Z');
CREATE TABLE study (name TEXT NOT NULL, made_by TEXT NOT NULL) STRICT;
INSERT INTO "study" VALUES('late-or-warped','0.2.0');
CREATE TABLE withdrawn (code TEXT NOT NULL PRIMARY KEY COLLATE NOCASE, cleaned INTEGER NOT NULL) STRICT;
CREATE INDEX event_of_session ON event (session, kind);
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('participant',13);
INSERT INTO "sqlite_sequence" VALUES('session',13);
INSERT INTO "sqlite_sequence" VALUES('event',430);
INSERT INTO "sqlite_sequence" VALUES('answer',277);
INSERT INTO "sqlite_sequence" VALUES('showing',45);
COMMIT;
