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
INSERT INTO "answer" VALUES(1,1,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:23.104Z',1);
INSERT INTO "answer" VALUES(2,1,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'experimenter','2031-07-23T16:41:33.169Z',2);
INSERT INTO "answer" VALUES(3,1,'trial/1/grade/grade',2,'trial',1,'grade','grade',4.25,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:37.195Z',2);
INSERT INTO "answer" VALUES(4,1,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'experimenter','2031-07-23T16:41:41.221Z',2);
INSERT INTO "answer" VALUES(5,1,'trial/1/acr/quality',2,'trial',1,'acr','quality',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:45.247Z',2);
INSERT INTO "answer" VALUES(6,1,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:49.273Z',2);
INSERT INTO "answer" VALUES(7,1,'trial/2/grade/grade',1,'trial',2,'grade','grade',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:41:59.338Z',3);
INSERT INTO "answer" VALUES(8,1,'trial/2/acr/quality',1,'trial',2,'acr','quality',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:03.364Z',3);
INSERT INTO "answer" VALUES(9,1,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:07.390Z',3);
INSERT INTO "answer" VALUES(10,1,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.75,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:17.455Z',4);
INSERT INTO "answer" VALUES(11,1,'trial/3/acr/quality',1,'trial',3,'acr','quality',5.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:21.481Z',4);
INSERT INTO "answer" VALUES(12,1,'trial/3/fms/fms',1,'trial',3,'fms','fms',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:25.507Z',4);
INSERT INTO "answer" VALUES(13,1,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:29.533Z',NULL);
INSERT INTO "answer" VALUES(14,1,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:33.559Z',NULL);
INSERT INTO "answer" VALUES(15,1,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:37.585Z',NULL);
INSERT INTO "answer" VALUES(16,1,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:41.611Z',NULL);
INSERT INTO "answer" VALUES(17,1,'after/vrsq/headache',1,'after',0,'vrsq','headache',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:45.637Z',NULL);
INSERT INTO "answer" VALUES(18,1,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:49.663Z',NULL);
INSERT INTO "answer" VALUES(19,1,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:53.689Z',NULL);
INSERT INTO "answer" VALUES(20,1,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:42:57.715Z',NULL);
INSERT INTO "answer" VALUES(21,1,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:43:01.741Z',NULL);
INSERT INTO "answer" VALUES(22,2,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:23.884Z',5);
INSERT INTO "answer" VALUES(23,2,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:43:33.949Z',6);
INSERT INTO "answer" VALUES(24,2,'trial/1/grade/grade',2,'trial',1,'grade','grade',3.5,2.65000003300000042116e+00,'participant','2031-07-23T16:43:37.975Z',6);
INSERT INTO "answer" VALUES(25,2,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'participant','2031-07-23T16:43:42.001Z',6);
INSERT INTO "answer" VALUES(26,2,'trial/1/acr/quality',2,'trial',1,'acr','quality',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:46.027Z',6);
INSERT INTO "answer" VALUES(27,2,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:43:50.053Z',6);
INSERT INTO "answer" VALUES(28,2,'trial/2/grade/grade',1,'trial',2,'grade','grade',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:44:00.118Z',7);
INSERT INTO "answer" VALUES(29,2,'trial/2/acr/quality',1,'trial',2,'acr','quality',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:44:04.144Z',7);
INSERT INTO "answer" VALUES(30,2,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:08.170Z',7);
INSERT INTO "answer" VALUES(31,2,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.25,2.65000003300000042116e+00,'participant','2031-07-23T16:44:18.235Z',8);
INSERT INTO "answer" VALUES(32,2,'trial/3/acr/quality',1,'trial',3,'acr','quality',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:22.261Z',8);
INSERT INTO "answer" VALUES(33,2,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:26.287Z',8);
INSERT INTO "answer" VALUES(34,2,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:30.313Z',NULL);
INSERT INTO "answer" VALUES(35,2,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:34.339Z',NULL);
INSERT INTO "answer" VALUES(36,2,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:38.365Z',NULL);
INSERT INTO "answer" VALUES(37,2,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:42.391Z',NULL);
INSERT INTO "answer" VALUES(38,2,'after/vrsq/headache',1,'after',0,'vrsq','headache',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:46.417Z',NULL);
INSERT INTO "answer" VALUES(39,2,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:50.443Z',NULL);
INSERT INTO "answer" VALUES(40,2,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:54.469Z',NULL);
INSERT INTO "answer" VALUES(41,2,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:44:58.495Z',NULL);
INSERT INTO "answer" VALUES(42,2,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:45:02.521Z',NULL);
INSERT INTO "answer" VALUES(43,3,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:45:24.664Z',9);
INSERT INTO "answer" VALUES(44,3,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:45:34.729Z',10);
INSERT INTO "answer" VALUES(45,3,'trial/1/grade/grade',2,'trial',1,'grade','grade',2.25,3.65000003300000042116e+00,'participant','2031-07-23T16:45:38.755Z',10);
INSERT INTO "answer" VALUES(46,3,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'participant','2031-07-23T16:45:42.781Z',10);
INSERT INTO "answer" VALUES(47,3,'trial/1/acr/quality',2,'trial',1,'acr','quality',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:45:46.807Z',10);
INSERT INTO "answer" VALUES(48,3,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:45:50.833Z',10);
INSERT INTO "answer" VALUES(49,3,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:00.898Z',11);
INSERT INTO "answer" VALUES(50,3,'trial/2/acr/quality',1,'trial',2,'acr','quality',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:04.924Z',11);
INSERT INTO "answer" VALUES(51,3,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:08.950Z',11);
INSERT INTO "answer" VALUES(52,3,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.25,3.65000003300000042116e+00,'participant','2031-07-23T16:46:19.015Z',12);
INSERT INTO "answer" VALUES(53,3,'trial/3/acr/quality',1,'trial',3,'acr','quality',4.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:23.041Z',12);
INSERT INTO "answer" VALUES(54,3,'trial/3/fms/fms',1,'trial',3,'fms','fms',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:27.067Z',12);
INSERT INTO "answer" VALUES(55,3,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:31.093Z',NULL);
INSERT INTO "answer" VALUES(56,3,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:35.119Z',NULL);
INSERT INTO "answer" VALUES(57,3,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:39.145Z',NULL);
INSERT INTO "answer" VALUES(58,3,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:43.171Z',NULL);
INSERT INTO "answer" VALUES(59,3,'after/vrsq/headache',1,'after',0,'vrsq','headache',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:47.197Z',NULL);
INSERT INTO "answer" VALUES(60,3,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:51.223Z',NULL);
INSERT INTO "answer" VALUES(61,3,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:55.249Z',NULL);
INSERT INTO "answer" VALUES(62,3,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:46:59.275Z',NULL);
INSERT INTO "answer" VALUES(63,3,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:47:03.301Z',NULL);
INSERT INTO "answer" VALUES(64,4,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,4.650000033,'participant','2031-07-23T16:47:25.444Z',13);
INSERT INTO "answer" VALUES(65,4,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:47:41.548Z',15);
INSERT INTO "answer" VALUES(66,4,'trial/1/grade/grade',2,'trial',1,'grade','grade',1.0,4.650000033,'participant','2031-07-23T16:47:45.574Z',15);
INSERT INTO "answer" VALUES(67,4,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'participant','2031-07-23T16:47:49.600Z',15);
INSERT INTO "answer" VALUES(68,4,'trial/1/acr/quality',2,'trial',1,'acr','quality',2.0,4.650000033,'participant','2031-07-23T16:47:53.626Z',15);
INSERT INTO "answer" VALUES(69,4,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,4.650000033,'participant','2031-07-23T16:47:57.652Z',15);
INSERT INTO "answer" VALUES(70,4,'trial/2/grade/grade',1,'trial',2,'grade','grade',5.0,4.650000033,'participant','2031-07-23T16:48:07.717Z',16);
INSERT INTO "answer" VALUES(71,4,'trial/2/acr/quality',1,'trial',2,'acr','quality',5.0,4.650000033,'participant','2031-07-23T16:48:11.743Z',16);
INSERT INTO "answer" VALUES(72,4,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,4.650000033,'participant','2031-07-23T16:48:15.769Z',16);
INSERT INTO "answer" VALUES(73,4,'trial/3/grade/grade',1,'trial',3,'grade','grade',1.0,4.650000033,'participant','2031-07-23T16:48:25.834Z',17);
INSERT INTO "answer" VALUES(74,4,'trial/3/acr/quality',1,'trial',3,'acr','quality',1.0,4.650000033,'participant','2031-07-23T16:48:29.860Z',17);
INSERT INTO "answer" VALUES(75,4,'trial/3/fms/fms',1,'trial',3,'fms','fms',4.0,4.650000033,'participant','2031-07-23T16:48:33.886Z',17);
INSERT INTO "answer" VALUES(76,4,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',1.0,4.650000033,'participant','2031-07-23T16:48:37.912Z',NULL);
INSERT INTO "answer" VALUES(77,4,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',2.0,4.650000033,'participant','2031-07-23T16:48:41.938Z',NULL);
INSERT INTO "answer" VALUES(78,4,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',1.0,4.650000033,'participant','2031-07-23T16:48:45.964Z',NULL);
INSERT INTO "answer" VALUES(79,4,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',1.0,4.650000033,'participant','2031-07-23T16:48:49.990Z',NULL);
INSERT INTO "answer" VALUES(80,4,'after/vrsq/headache',1,'after',0,'vrsq','headache',0.0,4.650000033,'participant','2031-07-23T16:48:54.016Z',NULL);
INSERT INTO "answer" VALUES(81,4,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,4.650000033,'participant','2031-07-23T16:48:58.042Z',NULL);
INSERT INTO "answer" VALUES(82,4,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',2.0,4.650000033,'participant','2031-07-23T16:49:02.068Z',NULL);
INSERT INTO "answer" VALUES(83,4,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',0.0,4.650000033,'participant','2031-07-23T16:49:06.094Z',NULL);
INSERT INTO "answer" VALUES(84,4,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',0.0,4.650000033,'participant','2031-07-23T16:49:10.120Z',NULL);
INSERT INTO "answer" VALUES(85,5,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:49:32.263Z',18);
INSERT INTO "answer" VALUES(86,5,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'experimenter','2031-07-23T16:49:42.328Z',19);
INSERT INTO "answer" VALUES(87,5,'trial/1/grade/grade',2,'trial',1,'grade','grade',4.25,1.65000003300000019912e+00,'experimenter','2031-07-23T16:49:46.354Z',19);
INSERT INTO "answer" VALUES(88,5,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'experimenter','2031-07-23T16:49:50.380Z',19);
INSERT INTO "answer" VALUES(89,5,'trial/1/acr/quality',2,'trial',1,'acr','quality',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:49:54.406Z',19);
INSERT INTO "answer" VALUES(90,5,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:49:58.432Z',19);
INSERT INTO "answer" VALUES(91,5,'trial/2/grade/grade',1,'trial',2,'grade','grade',2.5,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:08.497Z',20);
INSERT INTO "answer" VALUES(92,5,'trial/2/acr/quality',1,'trial',2,'acr','quality',1.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:12.523Z',20);
INSERT INTO "answer" VALUES(93,5,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:16.549Z',20);
INSERT INTO "answer" VALUES(94,5,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:20.575Z',NULL);
INSERT INTO "answer" VALUES(95,5,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',0.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:24.601Z',NULL);
INSERT INTO "answer" VALUES(96,5,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:28.627Z',NULL);
INSERT INTO "answer" VALUES(97,5,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:32.653Z',NULL);
INSERT INTO "answer" VALUES(98,5,'after/vrsq/headache',1,'after',0,'vrsq','headache',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:36.679Z',NULL);
INSERT INTO "answer" VALUES(99,5,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:40.705Z',NULL);
INSERT INTO "answer" VALUES(100,5,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:44.731Z',NULL);
INSERT INTO "answer" VALUES(101,5,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',3.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:48.757Z',NULL);
INSERT INTO "answer" VALUES(102,5,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',2.0,1.65000003300000019912e+00,'experimenter','2031-07-23T16:50:52.783Z',NULL);
INSERT INTO "answer" VALUES(103,6,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:51:14.926Z',21);
INSERT INTO "answer" VALUES(104,6,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:51:24.991Z',22);
INSERT INTO "answer" VALUES(105,6,'trial/1/grade/grade',2,'trial',1,'grade','grade',3.5,2.65000003300000042116e+00,'participant','2031-07-23T16:51:29.017Z',22);
INSERT INTO "answer" VALUES(106,6,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'participant','2031-07-23T16:51:33.043Z',22);
INSERT INTO "answer" VALUES(107,6,'trial/1/acr/quality',2,'trial',1,'acr','quality',4.0,2.65000003300000042116e+00,'participant','2031-07-23T16:51:37.069Z',22);
INSERT INTO "answer" VALUES(108,6,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,2.65000003300000042116e+00,'participant','2031-07-23T16:51:41.095Z',22);
INSERT INTO "answer" VALUES(109,6,'trial/2/grade/grade',1,'trial',2,'grade','grade',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:51:51.160Z',23);
INSERT INTO "answer" VALUES(110,6,'trial/2/acr/quality',1,'trial',2,'acr','quality',NULL,2.65000003300000042116e+00,'participant','2031-07-23T16:51:55.186Z',23);
INSERT INTO "answer" VALUES(111,6,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:51:59.212Z',23);
INSERT INTO "answer" VALUES(112,6,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:03.238Z',NULL);
INSERT INTO "answer" VALUES(113,6,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',0.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:07.264Z',NULL);
INSERT INTO "answer" VALUES(114,6,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:11.290Z',NULL);
INSERT INTO "answer" VALUES(115,6,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:15.316Z',NULL);
INSERT INTO "answer" VALUES(116,6,'after/vrsq/headache',1,'after',0,'vrsq','headache',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:19.342Z',NULL);
INSERT INTO "answer" VALUES(117,6,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:23.368Z',NULL);
INSERT INTO "answer" VALUES(118,6,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',3.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:27.394Z',NULL);
INSERT INTO "answer" VALUES(119,6,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:31.420Z',NULL);
INSERT INTO "answer" VALUES(120,6,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',1.0,2.65000003300000042116e+00,'participant','2031-07-23T16:52:35.446Z',NULL);
INSERT INTO "answer" VALUES(121,7,'practice/fms/fms',1,'practice',0,'fms','fms',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:52:57.589Z',24);
INSERT INTO "answer" VALUES(122,7,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:53:07.654Z',25);
INSERT INTO "answer" VALUES(123,7,'trial/1/grade/grade',2,'trial',1,'grade','grade',2.25,3.65000003300000042116e+00,'participant','2031-07-23T16:53:11.680Z',25);
INSERT INTO "answer" VALUES(124,7,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'participant','2031-07-23T16:53:15.706Z',25);
INSERT INTO "answer" VALUES(125,7,'trial/1/acr/quality',2,'trial',1,'acr','quality',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:19.732Z',25);
INSERT INTO "answer" VALUES(126,7,'trial/1/fms/fms',1,'trial',1,'fms','fms',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:23.758Z',25);
INSERT INTO "answer" VALUES(127,7,'trial/2/grade/grade',1,'trial',2,'grade','grade',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:33.823Z',26);
INSERT INTO "answer" VALUES(128,7,'trial/2/acr/quality',1,'trial',2,'acr','quality',5.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:37.849Z',26);
INSERT INTO "answer" VALUES(129,7,'trial/2/fms/fms',1,'trial',2,'fms','fms',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:41.875Z',26);
INSERT INTO "answer" VALUES(130,7,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:45.901Z',NULL);
INSERT INTO "answer" VALUES(131,7,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',1.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:49.927Z',NULL);
INSERT INTO "answer" VALUES(132,7,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:53.953Z',NULL);
INSERT INTO "answer" VALUES(133,7,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:53:57.979Z',NULL);
INSERT INTO "answer" VALUES(134,7,'after/vrsq/headache',1,'after',0,'vrsq','headache',2.0,3.65000003300000042116e+00,'participant','2031-07-23T16:54:02.005Z',NULL);
INSERT INTO "answer" VALUES(135,7,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:54:06.031Z',NULL);
INSERT INTO "answer" VALUES(136,7,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:54:10.057Z',NULL);
INSERT INTO "answer" VALUES(137,7,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',3.0,3.65000003300000042116e+00,'participant','2031-07-23T16:54:14.083Z',NULL);
INSERT INTO "answer" VALUES(138,7,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',0.0,3.65000003300000042116e+00,'participant','2031-07-23T16:54:18.109Z',NULL);
INSERT INTO "answer" VALUES(139,8,'practice/fms/fms',1,'practice',0,'fms','fms',1.0,4.650000033,'participant','2031-07-23T16:54:40.252Z',27);
INSERT INTO "answer" VALUES(140,8,'trial/1/grade/grade',1,'trial',1,'grade','grade',1.0,0.5,'participant','2031-07-23T16:54:56.356Z',29);
INSERT INTO "answer" VALUES(141,8,'trial/1/grade/grade',2,'trial',1,'grade','grade',1.25,4.650000033,'participant','2031-07-23T16:55:00.382Z',29);
INSERT INTO "answer" VALUES(142,8,'trial/1/acr/quality',1,'trial',1,'acr','quality',1.0,0.5,'participant','2031-07-23T16:55:04.408Z',29);
INSERT INTO "answer" VALUES(143,8,'trial/1/acr/quality',2,'trial',1,'acr','quality',1.0,4.650000033,'participant','2031-07-23T16:55:08.434Z',29);
INSERT INTO "answer" VALUES(144,8,'trial/1/fms/fms',1,'trial',1,'fms','fms',2.0,4.650000033,'participant','2031-07-23T16:55:12.460Z',29);
INSERT INTO "answer" VALUES(145,8,'trial/2/grade/grade',1,'trial',2,'grade','grade',1.75,4.650000033,'participant','2031-07-23T16:55:22.525Z',30);
INSERT INTO "answer" VALUES(146,8,'trial/2/acr/quality',1,'trial',2,'acr','quality',5.0,4.650000033,'participant','2031-07-23T16:55:26.551Z',30);
INSERT INTO "answer" VALUES(147,8,'trial/2/fms/fms',1,'trial',2,'fms','fms',3.0,4.650000033,'participant','2031-07-23T16:55:30.577Z',30);
INSERT INTO "answer" VALUES(148,8,'after/vrsq/general_discomfort',1,'after',0,'vrsq','general_discomfort',2.0,4.650000033,'participant','2031-07-23T16:55:34.603Z',NULL);
INSERT INTO "answer" VALUES(149,8,'after/vrsq/fatigue',1,'after',0,'vrsq','fatigue',0.0,4.650000033,'participant','2031-07-23T16:55:38.629Z',NULL);
INSERT INTO "answer" VALUES(150,8,'after/vrsq/eyestrain',1,'after',0,'vrsq','eyestrain',0.0,4.650000033,'participant','2031-07-23T16:55:42.655Z',NULL);
INSERT INTO "answer" VALUES(151,8,'after/vrsq/difficulty_focusing',1,'after',0,'vrsq','difficulty_focusing',1.0,4.650000033,'participant','2031-07-23T16:55:46.681Z',NULL);
INSERT INTO "answer" VALUES(152,8,'after/vrsq/headache',1,'after',0,'vrsq','headache',1.0,4.650000033,'participant','2031-07-23T16:55:50.707Z',NULL);
INSERT INTO "answer" VALUES(153,8,'after/vrsq/fullness_of_head',1,'after',0,'vrsq','fullness_of_head',2.0,4.650000033,'participant','2031-07-23T16:55:54.733Z',NULL);
INSERT INTO "answer" VALUES(154,8,'after/vrsq/blurred_vision',1,'after',0,'vrsq','blurred_vision',1.0,4.650000033,'participant','2031-07-23T16:55:58.759Z',NULL);
INSERT INTO "answer" VALUES(155,8,'after/vrsq/dizzy_eyes_closed',1,'after',0,'vrsq','dizzy_eyes_closed',1.0,4.650000033,'participant','2031-07-23T16:56:02.785Z',NULL);
INSERT INTO "answer" VALUES(156,8,'after/vrsq/vertigo',1,'after',0,'vrsq','vertigo',0.0,4.650000033,'participant','2031-07-23T16:56:06.811Z',NULL);
CREATE TABLE event (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session INTEGER NOT NULL REFERENCES session (id),
  kind TEXT NOT NULL,
  key TEXT NOT NULL,
  at_utc TEXT NOT NULL,
  mono_ns INTEGER NOT NULL,
  data TEXT NOT NULL
) STRICT;
INSERT INTO "event" VALUES(1,1,'begin','','2031-07-23T16:41:13.039Z',2013000000,'{"part":"run-1","row":0,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(2,1,'finished','consent','2031-07-23T16:41:15.052Z',4026000000,'{}');
INSERT INTO "event" VALUES(3,1,'showing','practice','2031-07-23T16:41:19.078Z',6039000000,'{"showing":1,"presentation":1}');
INSERT INTO "event" VALUES(4,1,'shown','practice','2031-07-23T16:41:21.091Z',8052000000,'{"showing":1,"complete":true}');
INSERT INTO "event" VALUES(5,1,'answer','practice/fms/fms','2031-07-23T16:41:25.117Z',10065000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(6,1,'showing','trial/1','2031-07-23T16:41:29.143Z',12078000000,'{"showing":2,"presentation":1}');
INSERT INTO "event" VALUES(7,1,'shown','trial/1','2031-07-23T16:41:31.156Z',14091000000,'{"showing":2,"complete":true}');
INSERT INTO "event" VALUES(8,1,'answer','trial/1/grade/grade','2031-07-23T16:41:35.182Z',16104000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(9,1,'answer','trial/1/grade/grade','2031-07-23T16:41:39.208Z',18117000000,'{"value":4.25,"revision":2}');
INSERT INTO "event" VALUES(10,1,'answer','trial/1/acr/quality','2031-07-23T16:41:43.234Z',20130000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(11,1,'answer','trial/1/acr/quality','2031-07-23T16:41:47.260Z',22143000000,'{"value":3.0,"revision":2}');
INSERT INTO "event" VALUES(12,1,'answer','trial/1/fms/fms','2031-07-23T16:41:51.286Z',24156000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(13,1,'showing','trial/2','2031-07-23T16:41:55.312Z',26169000000,'{"showing":3,"presentation":1}');
INSERT INTO "event" VALUES(14,1,'shown','trial/2','2031-07-23T16:41:57.325Z',28182000000,'{"showing":3,"complete":true}');
INSERT INTO "event" VALUES(15,1,'answer','trial/2/grade/grade','2031-07-23T16:42:01.351Z',30195000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(16,1,'answer','trial/2/acr/quality','2031-07-23T16:42:05.377Z',32208000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(17,1,'answer','trial/2/fms/fms','2031-07-23T16:42:09.403Z',34221000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(18,1,'showing','trial/3','2031-07-23T16:42:13.429Z',36234000000,'{"showing":4,"presentation":1}');
INSERT INTO "event" VALUES(19,1,'shown','trial/3','2031-07-23T16:42:15.442Z',38247000000,'{"showing":4,"complete":true}');
INSERT INTO "event" VALUES(20,1,'answer','trial/3/grade/grade','2031-07-23T16:42:19.468Z',40260000000,'{"value":1.75,"revision":1}');
INSERT INTO "event" VALUES(21,1,'answer','trial/3/acr/quality','2031-07-23T16:42:23.494Z',42273000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(22,1,'answer','trial/3/fms/fms','2031-07-23T16:42:27.520Z',44286000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(23,1,'answer','after/vrsq/general_discomfort','2031-07-23T16:42:31.546Z',46299000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(24,1,'answer','after/vrsq/fatigue','2031-07-23T16:42:35.572Z',48312000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(25,1,'answer','after/vrsq/eyestrain','2031-07-23T16:42:39.598Z',50325000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(26,1,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:42:43.624Z',52338000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(27,1,'answer','after/vrsq/headache','2031-07-23T16:42:47.650Z',54351000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(28,1,'answer','after/vrsq/fullness_of_head','2031-07-23T16:42:51.676Z',56364000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(29,1,'answer','after/vrsq/blurred_vision','2031-07-23T16:42:55.702Z',58377000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(30,1,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:42:59.728Z',60390000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(31,1,'answer','after/vrsq/vertigo','2031-07-23T16:43:03.754Z',62403000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(32,1,'remark','trial/1','2031-07-23T16:43:05.767Z',64416000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(33,1,'end','','2031-07-23T16:43:07.780Z',66429000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(34,2,'begin','','2031-07-23T16:43:13.819Z',68442000000,'{"part":"run-1","row":4,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(35,2,'finished','consent','2031-07-23T16:43:15.832Z',70455000000,'{}');
INSERT INTO "event" VALUES(36,2,'showing','practice','2031-07-23T16:43:19.858Z',72468000000,'{"showing":5,"presentation":1}');
INSERT INTO "event" VALUES(37,2,'shown','practice','2031-07-23T16:43:21.871Z',74481000000,'{"showing":5,"complete":true}');
INSERT INTO "event" VALUES(38,2,'answer','practice/fms/fms','2031-07-23T16:43:25.897Z',76494000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(39,2,'showing','trial/1','2031-07-23T16:43:29.923Z',78507000000,'{"showing":6,"presentation":1}');
INSERT INTO "event" VALUES(40,2,'shown','trial/1','2031-07-23T16:43:31.936Z',80520000000,'{"showing":6,"complete":true}');
INSERT INTO "event" VALUES(41,2,'answer','trial/1/grade/grade','2031-07-23T16:43:35.962Z',82533000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(42,2,'answer','trial/1/grade/grade','2031-07-23T16:43:39.988Z',84546000000,'{"value":3.5,"revision":2}');
INSERT INTO "event" VALUES(43,2,'answer','trial/1/acr/quality','2031-07-23T16:43:44.014Z',86559000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(44,2,'answer','trial/1/acr/quality','2031-07-23T16:43:48.040Z',88572000000,'{"value":4.0,"revision":2}');
INSERT INTO "event" VALUES(45,2,'answer','trial/1/fms/fms','2031-07-23T16:43:52.066Z',90585000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(46,2,'showing','trial/2','2031-07-23T16:43:56.092Z',92598000000,'{"showing":7,"presentation":1}');
INSERT INTO "event" VALUES(47,2,'shown','trial/2','2031-07-23T16:43:58.105Z',94611000000,'{"showing":7,"complete":true}');
INSERT INTO "event" VALUES(48,2,'answer','trial/2/grade/grade','2031-07-23T16:44:02.131Z',96624000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(49,2,'answer','trial/2/acr/quality','2031-07-23T16:44:06.157Z',98637000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(50,2,'answer','trial/2/fms/fms','2031-07-23T16:44:10.183Z',100650000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(51,2,'showing','trial/3','2031-07-23T16:44:14.209Z',102663000000,'{"showing":8,"presentation":1}');
INSERT INTO "event" VALUES(52,2,'shown','trial/3','2031-07-23T16:44:16.222Z',104676000000,'{"showing":8,"complete":true}');
INSERT INTO "event" VALUES(53,2,'answer','trial/3/grade/grade','2031-07-23T16:44:20.248Z',106689000000,'{"value":1.25,"revision":1}');
INSERT INTO "event" VALUES(54,2,'answer','trial/3/acr/quality','2031-07-23T16:44:24.274Z',108702000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(55,2,'answer','trial/3/fms/fms','2031-07-23T16:44:28.300Z',110715000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(56,2,'answer','after/vrsq/general_discomfort','2031-07-23T16:44:32.326Z',112728000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(57,2,'answer','after/vrsq/fatigue','2031-07-23T16:44:36.352Z',114741000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(58,2,'answer','after/vrsq/eyestrain','2031-07-23T16:44:40.378Z',116754000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(59,2,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:44:44.404Z',118767000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(60,2,'answer','after/vrsq/headache','2031-07-23T16:44:48.430Z',120780000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(61,2,'answer','after/vrsq/fullness_of_head','2031-07-23T16:44:52.456Z',122793000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(62,2,'answer','after/vrsq/blurred_vision','2031-07-23T16:44:56.482Z',124806000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(63,2,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:45:00.508Z',126819000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(64,2,'answer','after/vrsq/vertigo','2031-07-23T16:45:04.534Z',128832000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(65,2,'remark','trial/1','2031-07-23T16:45:06.547Z',130845000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(66,2,'end','','2031-07-23T16:45:08.560Z',132858000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(67,3,'begin','','2031-07-23T16:45:14.599Z',134871000000,'{"part":"run-1","row":2,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(68,3,'finished','consent','2031-07-23T16:45:16.612Z',136884000000,'{}');
INSERT INTO "event" VALUES(69,3,'showing','practice','2031-07-23T16:45:20.638Z',138897000000,'{"showing":9,"presentation":1}');
INSERT INTO "event" VALUES(70,3,'shown','practice','2031-07-23T16:45:22.651Z',140910000000,'{"showing":9,"complete":true}');
INSERT INTO "event" VALUES(71,3,'answer','practice/fms/fms','2031-07-23T16:45:26.677Z',142923000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(72,3,'showing','trial/1','2031-07-23T16:45:30.703Z',144936000000,'{"showing":10,"presentation":1}');
INSERT INTO "event" VALUES(73,3,'shown','trial/1','2031-07-23T16:45:32.716Z',146949000000,'{"showing":10,"complete":true}');
INSERT INTO "event" VALUES(74,3,'answer','trial/1/grade/grade','2031-07-23T16:45:36.742Z',148962000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(75,3,'answer','trial/1/grade/grade','2031-07-23T16:45:40.768Z',150975000000,'{"value":2.25,"revision":2}');
INSERT INTO "event" VALUES(76,3,'answer','trial/1/acr/quality','2031-07-23T16:45:44.794Z',152988000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(77,3,'answer','trial/1/acr/quality','2031-07-23T16:45:48.820Z',155001000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(78,3,'answer','trial/1/fms/fms','2031-07-23T16:45:52.846Z',157014000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(79,3,'showing','trial/2','2031-07-23T16:45:56.872Z',159027000000,'{"showing":11,"presentation":1}');
INSERT INTO "event" VALUES(80,3,'shown','trial/2','2031-07-23T16:45:58.885Z',161040000000,'{"showing":11,"complete":true}');
INSERT INTO "event" VALUES(81,3,'answer','trial/2/grade/grade','2031-07-23T16:46:02.911Z',163053000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(82,3,'answer','trial/2/acr/quality','2031-07-23T16:46:06.937Z',165066000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(83,3,'answer','trial/2/fms/fms','2031-07-23T16:46:10.963Z',167079000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(84,3,'showing','trial/3','2031-07-23T16:46:14.989Z',169092000000,'{"showing":12,"presentation":1}');
INSERT INTO "event" VALUES(85,3,'shown','trial/3','2031-07-23T16:46:17.002Z',171105000000,'{"showing":12,"complete":true}');
INSERT INTO "event" VALUES(86,3,'answer','trial/3/grade/grade','2031-07-23T16:46:21.028Z',173118000000,'{"value":1.25,"revision":1}');
INSERT INTO "event" VALUES(87,3,'answer','trial/3/acr/quality','2031-07-23T16:46:25.054Z',175131000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(88,3,'answer','trial/3/fms/fms','2031-07-23T16:46:29.080Z',177144000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(89,3,'answer','after/vrsq/general_discomfort','2031-07-23T16:46:33.106Z',179157000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(90,3,'answer','after/vrsq/fatigue','2031-07-23T16:46:37.132Z',181170000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(91,3,'answer','after/vrsq/eyestrain','2031-07-23T16:46:41.158Z',183183000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(92,3,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:46:45.184Z',185196000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(93,3,'answer','after/vrsq/headache','2031-07-23T16:46:49.210Z',187209000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(94,3,'answer','after/vrsq/fullness_of_head','2031-07-23T16:46:53.236Z',189222000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(95,3,'answer','after/vrsq/blurred_vision','2031-07-23T16:46:57.262Z',191235000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(96,3,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:47:01.288Z',193248000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(97,3,'answer','after/vrsq/vertigo','2031-07-23T16:47:05.314Z',195261000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(98,3,'remark','trial/1','2031-07-23T16:47:07.327Z',197274000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(99,3,'end','','2031-07-23T16:47:09.340Z',199287000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(100,4,'begin','','2031-07-23T16:47:15.379Z',201300000000,'{"part":"run-1","row":5,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(101,4,'finished','consent','2031-07-23T16:47:17.392Z',203313000000,'{}');
INSERT INTO "event" VALUES(102,4,'showing','practice','2031-07-23T16:47:21.418Z',205326000000,'{"showing":13,"presentation":1}');
INSERT INTO "event" VALUES(103,4,'shown','practice','2031-07-23T16:47:23.431Z',207339000000,'{"showing":13,"complete":true}');
INSERT INTO "event" VALUES(104,4,'answer','practice/fms/fms','2031-07-23T16:47:27.457Z',209352000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(105,4,'showing','trial/1','2031-07-23T16:47:31.483Z',211365000000,'{"showing":14,"presentation":1}');
INSERT INTO "event" VALUES(106,4,'shown','trial/1','2031-07-23T16:47:33.496Z',213378000000,'{"showing":14,"complete":false}');
INSERT INTO "event" VALUES(107,4,'showing','trial/1','2031-07-23T16:47:37.522Z',215391000000,'{"showing":15,"presentation":2}');
INSERT INTO "event" VALUES(108,4,'shown','trial/1','2031-07-23T16:47:39.535Z',217404000000,'{"showing":15,"complete":true}');
INSERT INTO "event" VALUES(109,4,'answer','trial/1/grade/grade','2031-07-23T16:47:43.561Z',219417000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(110,4,'answer','trial/1/grade/grade','2031-07-23T16:47:47.587Z',221430000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(111,4,'answer','trial/1/acr/quality','2031-07-23T16:47:51.613Z',223443000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(112,4,'answer','trial/1/acr/quality','2031-07-23T16:47:55.639Z',225456000000,'{"value":2.0,"revision":2}');
INSERT INTO "event" VALUES(113,4,'answer','trial/1/fms/fms','2031-07-23T16:47:59.665Z',227469000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(114,4,'showing','trial/2','2031-07-23T16:48:03.691Z',229482000000,'{"showing":16,"presentation":1}');
INSERT INTO "event" VALUES(115,4,'shown','trial/2','2031-07-23T16:48:05.704Z',231495000000,'{"showing":16,"complete":true}');
INSERT INTO "event" VALUES(116,4,'answer','trial/2/grade/grade','2031-07-23T16:48:09.730Z',233508000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(117,4,'answer','trial/2/acr/quality','2031-07-23T16:48:13.756Z',235521000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(118,4,'answer','trial/2/fms/fms','2031-07-23T16:48:17.782Z',237534000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(119,4,'showing','trial/3','2031-07-23T16:48:21.808Z',239547000000,'{"showing":17,"presentation":1}');
INSERT INTO "event" VALUES(120,4,'shown','trial/3','2031-07-23T16:48:23.821Z',241560000000,'{"showing":17,"complete":true}');
INSERT INTO "event" VALUES(121,4,'answer','trial/3/grade/grade','2031-07-23T16:48:27.847Z',243573000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(122,4,'answer','trial/3/acr/quality','2031-07-23T16:48:31.873Z',245586000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(123,4,'answer','trial/3/fms/fms','2031-07-23T16:48:35.899Z',247599000000,'{"value":4.0,"revision":1}');
INSERT INTO "event" VALUES(124,4,'answer','after/vrsq/general_discomfort','2031-07-23T16:48:39.925Z',249612000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(125,4,'answer','after/vrsq/fatigue','2031-07-23T16:48:43.951Z',251625000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(126,4,'answer','after/vrsq/eyestrain','2031-07-23T16:48:47.977Z',253638000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(127,4,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:48:52.003Z',255651000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(128,4,'answer','after/vrsq/headache','2031-07-23T16:48:56.029Z',257664000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(129,4,'answer','after/vrsq/fullness_of_head','2031-07-23T16:49:00.055Z',259677000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(130,4,'answer','after/vrsq/blurred_vision','2031-07-23T16:49:04.081Z',261690000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(131,4,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:49:08.107Z',263703000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(132,4,'answer','after/vrsq/vertigo','2031-07-23T16:49:12.133Z',265716000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(133,4,'remark','trial/1','2031-07-23T16:49:14.146Z',267729000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(134,4,'end','','2031-07-23T16:49:16.159Z',269742000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(135,5,'begin','','2031-07-23T16:49:22.198Z',271755000000,'{"part":"run-2","row":0,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(136,5,'finished','consent','2031-07-23T16:49:24.211Z',273768000000,'{}');
INSERT INTO "event" VALUES(137,5,'showing','practice','2031-07-23T16:49:28.237Z',275781000000,'{"showing":18,"presentation":1}');
INSERT INTO "event" VALUES(138,5,'shown','practice','2031-07-23T16:49:30.250Z',277794000000,'{"showing":18,"complete":true}');
INSERT INTO "event" VALUES(139,5,'answer','practice/fms/fms','2031-07-23T16:49:34.276Z',279807000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(140,5,'showing','trial/1','2031-07-23T16:49:38.302Z',281820000000,'{"showing":19,"presentation":1}');
INSERT INTO "event" VALUES(141,5,'shown','trial/1','2031-07-23T16:49:40.315Z',283833000000,'{"showing":19,"complete":true}');
INSERT INTO "event" VALUES(142,5,'answer','trial/1/grade/grade','2031-07-23T16:49:44.341Z',285846000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(143,5,'answer','trial/1/grade/grade','2031-07-23T16:49:48.367Z',287859000000,'{"value":4.25,"revision":2}');
INSERT INTO "event" VALUES(144,5,'answer','trial/1/acr/quality','2031-07-23T16:49:52.393Z',289872000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(145,5,'answer','trial/1/acr/quality','2031-07-23T16:49:56.419Z',291885000000,'{"value":3.0,"revision":2}');
INSERT INTO "event" VALUES(146,5,'answer','trial/1/fms/fms','2031-07-23T16:50:00.445Z',293898000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(147,5,'showing','trial/2','2031-07-23T16:50:04.471Z',295911000000,'{"showing":20,"presentation":1}');
INSERT INTO "event" VALUES(148,5,'shown','trial/2','2031-07-23T16:50:06.484Z',297924000000,'{"showing":20,"complete":true}');
INSERT INTO "event" VALUES(149,5,'answer','trial/2/grade/grade','2031-07-23T16:50:10.510Z',299937000000,'{"value":2.5,"revision":1}');
INSERT INTO "event" VALUES(150,5,'answer','trial/2/acr/quality','2031-07-23T16:50:14.536Z',301950000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(151,5,'answer','trial/2/fms/fms','2031-07-23T16:50:18.562Z',303963000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(152,5,'answer','after/vrsq/general_discomfort','2031-07-23T16:50:22.588Z',305976000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(153,5,'answer','after/vrsq/fatigue','2031-07-23T16:50:26.614Z',307989000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(154,5,'answer','after/vrsq/eyestrain','2031-07-23T16:50:30.640Z',310002000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(155,5,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:50:34.666Z',312015000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(156,5,'answer','after/vrsq/headache','2031-07-23T16:50:38.692Z',314028000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(157,5,'answer','after/vrsq/fullness_of_head','2031-07-23T16:50:42.718Z',316041000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(158,5,'answer','after/vrsq/blurred_vision','2031-07-23T16:50:46.744Z',318054000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(159,5,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:50:50.770Z',320067000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(160,5,'answer','after/vrsq/vertigo','2031-07-23T16:50:54.796Z',322080000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(161,5,'remark','trial/1','2031-07-23T16:50:56.809Z',324093000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(162,5,'end','','2031-07-23T16:50:58.822Z',326106000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(163,6,'begin','','2031-07-23T16:51:04.861Z',328119000000,'{"part":"run-2","row":1,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(164,6,'finished','consent','2031-07-23T16:51:06.874Z',330132000000,'{}');
INSERT INTO "event" VALUES(165,6,'showing','practice','2031-07-23T16:51:10.900Z',332145000000,'{"showing":21,"presentation":1}');
INSERT INTO "event" VALUES(166,6,'shown','practice','2031-07-23T16:51:12.913Z',334158000000,'{"showing":21,"complete":true}');
INSERT INTO "event" VALUES(167,6,'answer','practice/fms/fms','2031-07-23T16:51:16.939Z',336171000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(168,6,'showing','trial/1','2031-07-23T16:51:20.965Z',338184000000,'{"showing":22,"presentation":1}');
INSERT INTO "event" VALUES(169,6,'shown','trial/1','2031-07-23T16:51:22.978Z',340197000000,'{"showing":22,"complete":true}');
INSERT INTO "event" VALUES(170,6,'answer','trial/1/grade/grade','2031-07-23T16:51:27.004Z',342210000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(171,6,'answer','trial/1/grade/grade','2031-07-23T16:51:31.030Z',344223000000,'{"value":3.5,"revision":2}');
INSERT INTO "event" VALUES(172,6,'answer','trial/1/acr/quality','2031-07-23T16:51:35.056Z',346236000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(173,6,'answer','trial/1/acr/quality','2031-07-23T16:51:39.082Z',348249000000,'{"value":4.0,"revision":2}');
INSERT INTO "event" VALUES(174,6,'answer','trial/1/fms/fms','2031-07-23T16:51:43.108Z',350262000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(175,6,'showing','trial/2','2031-07-23T16:51:47.134Z',352275000000,'{"showing":23,"presentation":1}');
INSERT INTO "event" VALUES(176,6,'shown','trial/2','2031-07-23T16:51:49.147Z',354288000000,'{"showing":23,"complete":true}');
INSERT INTO "event" VALUES(177,6,'answer','trial/2/grade/grade','2031-07-23T16:51:53.173Z',356301000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(178,6,'answer','trial/2/acr/quality','2031-07-23T16:51:57.199Z',358314000000,'{"value":null,"revision":1}');
INSERT INTO "event" VALUES(179,6,'answer','trial/2/fms/fms','2031-07-23T16:52:01.225Z',360327000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(180,6,'answer','after/vrsq/general_discomfort','2031-07-23T16:52:05.251Z',362340000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(181,6,'answer','after/vrsq/fatigue','2031-07-23T16:52:09.277Z',364353000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(182,6,'answer','after/vrsq/eyestrain','2031-07-23T16:52:13.303Z',366366000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(183,6,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:52:17.329Z',368379000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(184,6,'answer','after/vrsq/headache','2031-07-23T16:52:21.355Z',370392000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(185,6,'answer','after/vrsq/fullness_of_head','2031-07-23T16:52:25.381Z',372405000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(186,6,'answer','after/vrsq/blurred_vision','2031-07-23T16:52:29.407Z',374418000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(187,6,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:52:33.433Z',376431000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(188,6,'answer','after/vrsq/vertigo','2031-07-23T16:52:37.459Z',378444000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(189,6,'remark','trial/1','2031-07-23T16:52:39.472Z',380457000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(190,6,'end','','2031-07-23T16:52:41.485Z',382470000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(191,7,'begin','','2031-07-23T16:52:47.524Z',384483000000,'{"part":"run-2","row":0,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(192,7,'finished','consent','2031-07-23T16:52:49.537Z',386496000000,'{}');
INSERT INTO "event" VALUES(193,7,'showing','practice','2031-07-23T16:52:53.563Z',388509000000,'{"showing":24,"presentation":1}');
INSERT INTO "event" VALUES(194,7,'shown','practice','2031-07-23T16:52:55.576Z',390522000000,'{"showing":24,"complete":true}');
INSERT INTO "event" VALUES(195,7,'answer','practice/fms/fms','2031-07-23T16:52:59.602Z',392535000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(196,7,'showing','trial/1','2031-07-23T16:53:03.628Z',394548000000,'{"showing":25,"presentation":1}');
INSERT INTO "event" VALUES(197,7,'shown','trial/1','2031-07-23T16:53:05.641Z',396561000000,'{"showing":25,"complete":true}');
INSERT INTO "event" VALUES(198,7,'answer','trial/1/grade/grade','2031-07-23T16:53:09.667Z',398574000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(199,7,'answer','trial/1/grade/grade','2031-07-23T16:53:13.693Z',400587000000,'{"value":2.25,"revision":2}');
INSERT INTO "event" VALUES(200,7,'answer','trial/1/acr/quality','2031-07-23T16:53:17.719Z',402600000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(201,7,'answer','trial/1/acr/quality','2031-07-23T16:53:21.745Z',404613000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(202,7,'answer','trial/1/fms/fms','2031-07-23T16:53:25.771Z',406626000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(203,7,'showing','trial/2','2031-07-23T16:53:29.797Z',408639000000,'{"showing":26,"presentation":1}');
INSERT INTO "event" VALUES(204,7,'shown','trial/2','2031-07-23T16:53:31.810Z',410652000000,'{"showing":26,"complete":true}');
INSERT INTO "event" VALUES(205,7,'answer','trial/2/grade/grade','2031-07-23T16:53:35.836Z',412665000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(206,7,'answer','trial/2/acr/quality','2031-07-23T16:53:39.862Z',414678000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(207,7,'answer','trial/2/fms/fms','2031-07-23T16:53:43.888Z',416691000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(208,7,'answer','after/vrsq/general_discomfort','2031-07-23T16:53:47.914Z',418704000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(209,7,'answer','after/vrsq/fatigue','2031-07-23T16:53:51.940Z',420717000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(210,7,'answer','after/vrsq/eyestrain','2031-07-23T16:53:55.966Z',422730000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(211,7,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:53:59.992Z',424743000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(212,7,'answer','after/vrsq/headache','2031-07-23T16:54:04.018Z',426756000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(213,7,'answer','after/vrsq/fullness_of_head','2031-07-23T16:54:08.044Z',428769000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(214,7,'answer','after/vrsq/blurred_vision','2031-07-23T16:54:12.070Z',430782000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(215,7,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:54:16.096Z',432795000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(216,7,'answer','after/vrsq/vertigo','2031-07-23T16:54:20.122Z',434808000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(217,7,'remark','trial/1','2031-07-23T16:54:22.135Z',436821000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(218,7,'end','','2031-07-23T16:54:24.148Z',438834000000,'{"status":"complete","why":""}');
INSERT INTO "event" VALUES(219,8,'begin','','2031-07-23T16:54:30.187Z',440847000000,'{"part":"run-2","row":1,"plan_text_changed":false,"consent_version":"1","consent_sha256":"2bc7bc8b20843423c78faad5af3b666afc68db7e51236cefd39cc4173f7045e3"}');
INSERT INTO "event" VALUES(220,8,'finished','consent','2031-07-23T16:54:32.200Z',442860000000,'{}');
INSERT INTO "event" VALUES(221,8,'showing','practice','2031-07-23T16:54:36.226Z',444873000000,'{"showing":27,"presentation":1}');
INSERT INTO "event" VALUES(222,8,'shown','practice','2031-07-23T16:54:38.239Z',446886000000,'{"showing":27,"complete":true}');
INSERT INTO "event" VALUES(223,8,'answer','practice/fms/fms','2031-07-23T16:54:42.265Z',448899000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(224,8,'showing','trial/1','2031-07-23T16:54:46.291Z',450912000000,'{"showing":28,"presentation":1}');
INSERT INTO "event" VALUES(225,8,'shown','trial/1','2031-07-23T16:54:48.304Z',452925000000,'{"showing":28,"complete":false}');
INSERT INTO "event" VALUES(226,8,'showing','trial/1','2031-07-23T16:54:52.330Z',454938000000,'{"showing":29,"presentation":2}');
INSERT INTO "event" VALUES(227,8,'shown','trial/1','2031-07-23T16:54:54.343Z',456951000000,'{"showing":29,"complete":true}');
INSERT INTO "event" VALUES(228,8,'answer','trial/1/grade/grade','2031-07-23T16:54:58.369Z',458964000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(229,8,'answer','trial/1/grade/grade','2031-07-23T16:55:02.395Z',460977000000,'{"value":1.25,"revision":2}');
INSERT INTO "event" VALUES(230,8,'answer','trial/1/acr/quality','2031-07-23T16:55:06.421Z',462990000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(231,8,'answer','trial/1/acr/quality','2031-07-23T16:55:10.447Z',465003000000,'{"value":1.0,"revision":2}');
INSERT INTO "event" VALUES(232,8,'answer','trial/1/fms/fms','2031-07-23T16:55:14.473Z',467016000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(233,8,'showing','trial/2','2031-07-23T16:55:18.499Z',469029000000,'{"showing":30,"presentation":1}');
INSERT INTO "event" VALUES(234,8,'shown','trial/2','2031-07-23T16:55:20.512Z',471042000000,'{"showing":30,"complete":true}');
INSERT INTO "event" VALUES(235,8,'answer','trial/2/grade/grade','2031-07-23T16:55:24.538Z',473055000000,'{"value":1.75,"revision":1}');
INSERT INTO "event" VALUES(236,8,'answer','trial/2/acr/quality','2031-07-23T16:55:28.564Z',475068000000,'{"value":5.0,"revision":1}');
INSERT INTO "event" VALUES(237,8,'answer','trial/2/fms/fms','2031-07-23T16:55:32.590Z',477081000000,'{"value":3.0,"revision":1}');
INSERT INTO "event" VALUES(238,8,'answer','after/vrsq/general_discomfort','2031-07-23T16:55:36.616Z',479094000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(239,8,'answer','after/vrsq/fatigue','2031-07-23T16:55:40.642Z',481107000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(240,8,'answer','after/vrsq/eyestrain','2031-07-23T16:55:44.668Z',483120000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(241,8,'answer','after/vrsq/difficulty_focusing','2031-07-23T16:55:48.694Z',485133000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(242,8,'answer','after/vrsq/headache','2031-07-23T16:55:52.720Z',487146000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(243,8,'answer','after/vrsq/fullness_of_head','2031-07-23T16:55:56.746Z',489159000000,'{"value":2.0,"revision":1}');
INSERT INTO "event" VALUES(244,8,'answer','after/vrsq/blurred_vision','2031-07-23T16:56:00.772Z',491172000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(245,8,'answer','after/vrsq/dizzy_eyes_closed','2031-07-23T16:56:04.798Z',493185000000,'{"value":1.0,"revision":1}');
INSERT INTO "event" VALUES(246,8,'answer','after/vrsq/vertigo','2031-07-23T16:56:08.824Z',495198000000,'{"value":0.0,"revision":1}');
INSERT INTO "event" VALUES(247,8,'remark','trial/1','2031-07-23T16:56:10.837Z',497211000000,'{"by":"experimenter","text":"Maria said ouch"}');
INSERT INTO "event" VALUES(248,8,'end','','2031-07-23T16:56:12.850Z',499224000000,'{"status":"complete","why":""}');
CREATE TABLE participant (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE COLLATE NOCASE,
  sub TEXT NOT NULL UNIQUE,
  origin TEXT NOT NULL CHECK (origin IN ('person', 'pilot', 'simulated')),
  withdrawing INTEGER NOT NULL DEFAULT 0
) STRICT;
INSERT INTO "participant" VALUES(1,'run-1-0','mwfezlvxultb','person',0);
INSERT INTO "participant" VALUES(2,'run-1-1','b7fwgkl5ehl4','person',0);
INSERT INTO "participant" VALUES(3,'run-1-2','otzp5otxou87','person',0);
INSERT INTO "participant" VALUES(4,'run-1-3','2z6zus20aql8','person',0);
INSERT INTO "participant" VALUES(5,'run-2-0','39xzybj6e3wt','person',0);
INSERT INTO "participant" VALUES(6,'run-2-1','fq4o4ejpetid','person',0);
INSERT INTO "participant" VALUES(7,'run-2-2','kz98qb7pkgnc','person',0);
INSERT INTO "participant" VALUES(8,'run-2-3','ufhrdslj0if9','person',0);
CREATE TABLE plan (id INTEGER PRIMARY KEY, text TEXT NOT NULL, meaning TEXT NOT NULL, UNIQUE (text, meaning)) STRICT;
INSERT INTO "plan" VALUES(1,'schema = 1
name = "whole"
title = "Everything at once"
seed = 7
blind = "both"

[common]
scene = "planes"
size = "96x120"

[trial]
seconds = 20
repeats = 1
order = "williams"
scales = ["grade", "acr"]

[practice]
seconds = 60
latency = 10

[breaks]
every = 6
seconds = 30

[sickness]
scale = "fms"
every = 1
stop_at = 15
rise = 8

[questionnaires]
after = ["vrsq"]

[consent]
version = "1"
text = "You may stop at any moment."

[[part]]
name = "run-1"
[[part.condition]]
name = "late-200"
latency = 200
warp = "none"
fill = "none"
[[part.condition]]
name = "warped-200"
latency = 200
warp = "mesh"
guard = 1.2
[[part.condition]]
name = "reference"
latency = 0
reference = true

[[part]]
name = "run-2"
[[part.condition]]
name = "a"
loss = 0.02
[[part.condition]]
name = "b"
jitter = ''uniform:20''

[[family]]
name = "warped against late"
part = "run-1"
pairs = [
  ["late-200", "warped-200"],
  ["late-200", "reference"],
]
','{"conditions":[{"name":"late-200","settings":{"fill":"none","latency":200,"scene":"planes","size":"96x120","warp":"none"},"reference":false},{"name":"warped-200","settings":{"guard":1.2,"latency":200,"scene":"planes","size":"96x120","warp":"mesh"},"reference":false},{"name":"reference","settings":{"latency":0,"scene":"planes","size":"96x120"},"reference":true}],"seconds":20.0,"repeats":1,"order":"williams","seed":7,"scales":[{"name":"grade","asked":["",["grade","How good was that, all in all?"]],"range":[1.0,6.0,0.25],"anchors":{"1":"very good","2":"good","3":"satisfactory","4":"sufficient","5":"poor","6":"insufficient"},"low_is_good":true},{"name":"acr","asked":["",["quality","How good was the picture?"]],"range":[1.0,5.0,1.0],"anchors":{"1":"bad","2":"poor","3":"fair","4":"good","5":"excellent"},"low_is_good":false}],"practice":[{"name":"practice","settings":{"fill":"none","latency":10,"scene":"planes","size":"96x120","warp":"none"},"reference":false},60.0],"sickness":{"scale":{"name":"fms","asked":["",["fms","How sick do you feel now? Think of nausea, general discomfort and stomach problems."]],"range":[0.0,20.0,1.0],"anchors":{"0":"no sickness at all","20":"frank sickness"},"low_is_good":true},"every":1,"stop_at":15.0,"rise":8.0},"before":[],"after":[{"name":"vrsq","asked":["How much does this affect you right now?",["general_discomfort","General discomfort"],["fatigue","Fatigue"],["eyestrain","Eyestrain"],["difficulty_focusing","Difficulty focusing"],["headache","Headache"],["fullness_of_head","Fullness of head"],["blurred_vision","Blurred vision"],["dizzy_eyes_closed","Dizzy (eyes closed)"],["vertigo","Vertigo"]],"range":[0.0,3.0,1.0],"anchors":{"0":"none","1":"slight","2":"moderate","3":"severe"},"low_is_good":true}]}');
INSERT INTO "plan" VALUES(2,'schema = 1
name = "whole"
title = "Everything at once"
seed = 7
blind = "both"

[common]
scene = "planes"
size = "96x120"

[trial]
seconds = 20
repeats = 1
order = "williams"
scales = ["grade", "acr"]

[practice]
seconds = 60
latency = 10

[breaks]
every = 6
seconds = 30

[sickness]
scale = "fms"
every = 1
stop_at = 15
rise = 8

[questionnaires]
after = ["vrsq"]

[consent]
version = "1"
text = "You may stop at any moment."

[[part]]
name = "run-1"
[[part.condition]]
name = "late-200"
latency = 200
warp = "none"
fill = "none"
[[part.condition]]
name = "warped-200"
latency = 200
warp = "mesh"
guard = 1.2
[[part.condition]]
name = "reference"
latency = 0
reference = true

[[part]]
name = "run-2"
[[part.condition]]
name = "a"
loss = 0.02
[[part.condition]]
name = "b"
jitter = ''uniform:20''

[[family]]
name = "warped against late"
part = "run-1"
pairs = [
  ["late-200", "warped-200"],
  ["late-200", "reference"],
]
','{"conditions":[{"name":"a","settings":{"loss":0.02,"scene":"planes","size":"96x120"},"reference":false},{"name":"b","settings":{"jitter":"uniform:20","scene":"planes","size":"96x120"},"reference":false}],"seconds":20.0,"repeats":1,"order":"williams","seed":7,"scales":[{"name":"grade","asked":["",["grade","How good was that, all in all?"]],"range":[1.0,6.0,0.25],"anchors":{"1":"very good","2":"good","3":"satisfactory","4":"sufficient","5":"poor","6":"insufficient"},"low_is_good":true},{"name":"acr","asked":["",["quality","How good was the picture?"]],"range":[1.0,5.0,1.0],"anchors":{"1":"bad","2":"poor","3":"fair","4":"good","5":"excellent"},"low_is_good":false}],"practice":[{"name":"practice","settings":{"fill":"none","latency":10,"scene":"planes","size":"96x120","warp":"none"},"reference":false},60.0],"sickness":{"scale":{"name":"fms","asked":["",["fms","How sick do you feel now? Think of nausea, general discomfort and stomach problems."]],"range":[0.0,20.0,1.0],"anchors":{"0":"no sickness at all","20":"frank sickness"},"low_is_good":true},"every":1,"stop_at":15.0,"rise":8.0},"before":[],"after":[{"name":"vrsq","asked":["How much does this affect you right now?",["general_discomfort","General discomfort"],["fatigue","Fatigue"],["eyestrain","Eyestrain"],["difficulty_focusing","Difficulty focusing"],["headache","Headache"],["fullness_of_head","Fullness of head"],["blurred_vision","Blurred vision"],["dizzy_eyes_closed","Dizzy (eyes closed)"],["vertigo","Vertigo"]],"range":[0.0,3.0,1.0],"anchors":{"0":"none","1":"slight","2":"moderate","3":"severe"},"low_is_good":true}]}');
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
INSERT INTO "session" VALUES(1,1,1,'run-1',0,'[["late-200","reference","warped-200"]]',1,'complete','','2031-07-23T16:41:11.026Z','2031-07-23T16:43:09.793Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(2,2,1,'run-1',4,'[["late-200","warped-200","reference"]]',1,'complete','','2031-07-23T16:43:11.806Z','2031-07-23T16:45:10.573Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(3,3,1,'run-1',2,'[["warped-200","late-200","reference"]]',1,'complete','','2031-07-23T16:45:12.586Z','2031-07-23T16:47:11.353Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-run-1-2.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(4,4,1,'run-1',5,'[["reference","late-200","warped-200"]]',1,'complete','','2031-07-23T16:47:13.366Z','2031-07-23T16:49:18.172Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(5,5,1,'run-2',0,'[["a","b"]]',2,'complete','','2031-07-23T16:49:20.185Z','2031-07-23T16:51:00.835Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
INSERT INTO "session" VALUES(6,6,1,'run-2',1,'[["b","a"]]',2,'complete','','2031-07-23T16:51:02.848Z','2031-07-23T16:52:43.498Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"openxr","machine":{"system":"Linux","release":"6"},"display":{"runtime":"Monado","runtime_version":"25.0.0","headset":"Index"}}');
INSERT INTO "session" VALUES(7,7,1,'run-2',0,'[["a","b"]]',2,'complete','','2031-07-23T16:52:45.511Z','2031-07-23T16:54:26.161Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"},"trace":"secret-of-run-2-2.csv","trace_axes":"unity, assumed"}');
INSERT INTO "session" VALUES(8,8,1,'run-2',1,'[["b","a"]]',2,'complete','','2031-07-23T16:54:28.174Z','2031-07-23T16:56:14.863Z','{"hmdwarp":"0.3.0","headset":"rift-dk1","source":"desktop","machine":{"system":"Linux","release":"6"}}');
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
INSERT INTO "showing" VALUES(1,1,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','mwfezlvxultb_ses-1_trial-0_1.csv','{"latency_ms_median":401.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:41:17.065Z');
INSERT INTO "showing" VALUES(2,1,'trial/1',1,1,'late-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"none","fill":"none"}','mwfezlvxultb_ses-1_trial-1_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:27.130Z');
INSERT INTO "showing" VALUES(3,1,'trial/2',2,1,'reference',1,1,'{"scene":"planes","size":"96x120","latency":0}','mwfezlvxultb_ses-1_trial-2_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:41:53.299Z');
INSERT INTO "showing" VALUES(4,1,'trial/3',3,1,'warped-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"mesh","guard":1.2}','mwfezlvxultb_ses-1_trial-3_1.csv','{"latency_ms_median":422.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":27.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:42:11.416Z');
INSERT INTO "showing" VALUES(5,2,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','b7fwgkl5ehl4_ses-1_trial-0_1.csv','{"latency_ms_median":402.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:43:17.845Z');
INSERT INTO "showing" VALUES(6,2,'trial/1',1,1,'late-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"none","fill":"none"}','b7fwgkl5ehl4_ses-1_trial-1_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:43:27.910Z');
INSERT INTO "showing" VALUES(7,2,'trial/2',2,1,'warped-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"mesh","guard":1.2}','b7fwgkl5ehl4_ses-1_trial-2_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:43:54.079Z');
INSERT INTO "showing" VALUES(8,2,'trial/3',3,1,'reference',1,1,'{"scene":"planes","size":"96x120","latency":0}','b7fwgkl5ehl4_ses-1_trial-3_1.csv','{"latency_ms_median":423.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:44:12.196Z');
INSERT INTO "showing" VALUES(9,3,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','otzp5otxou87_ses-1_trial-0_1.csv','{"latency_ms_median":403.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:45:18.625Z');
INSERT INTO "showing" VALUES(10,3,'trial/1',1,1,'warped-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"mesh","guard":1.2}','otzp5otxou87_ses-1_trial-1_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:28.690Z');
INSERT INTO "showing" VALUES(11,3,'trial/2',2,1,'late-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"none","fill":"none"}','otzp5otxou87_ses-1_trial-2_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:45:54.859Z');
INSERT INTO "showing" VALUES(12,3,'trial/3',3,1,'reference',1,1,'{"scene":"planes","size":"96x120","latency":0}','otzp5otxou87_ses-1_trial-3_1.csv','{"latency_ms_median":424.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:46:12.976Z');
INSERT INTO "showing" VALUES(13,4,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','2z6zus20aql8_ses-1_trial-0_1.csv','{"latency_ms_median":404.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:47:19.405Z');
INSERT INTO "showing" VALUES(14,4,'trial/1',1,1,'reference',1,0,'{"scene":"planes","size":"96x120","latency":0}','2z6zus20aql8_ses-1_trial-1_1.csv','{}','{}','2031-07-23T16:47:29.470Z');
INSERT INTO "showing" VALUES(15,4,'trial/1',1,1,'reference',2,1,'{"scene":"planes","size":"96x120","latency":0}','2z6zus20aql8_ses-1_trial-1_2.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:47:35.509Z');
INSERT INTO "showing" VALUES(16,4,'trial/2',2,1,'late-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"none","fill":"none"}','2z6zus20aql8_ses-1_trial-2_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:01.678Z');
INSERT INTO "showing" VALUES(17,4,'trial/3',3,1,'warped-200',1,1,'{"scene":"planes","size":"96x120","latency":200,"warp":"mesh","guard":1.2}','2z6zus20aql8_ses-1_trial-3_1.csv','{"latency_ms_median":425.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":26.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:48:19.795Z');
INSERT INTO "showing" VALUES(18,5,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','39xzybj6e3wt_ses-1_trial-0_1.csv','{"latency_ms_median":401.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.0,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:49:26.224Z');
INSERT INTO "showing" VALUES(19,5,'trial/1',1,1,'a',1,1,'{"scene":"planes","size":"96x120","loss":0.02}','39xzybj6e3wt_ses-1_trial-1_1.csv','{"latency_ms_median":408.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":29.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:49:36.289Z');
INSERT INTO "showing" VALUES(20,5,'trial/2',2,1,'b',1,1,'{"scene":"planes","size":"96x120","jitter":"uniform:20"}','39xzybj6e3wt_ses-1_trial-2_1.csv','{"latency_ms_median":415.5,"latency_ms_sd":1.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":28.0,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:50:02.458Z');
INSERT INTO "showing" VALUES(21,6,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','fq4o4ejpetid_ses-1_trial-0_1.csv','{"latency_ms_median":402.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.1,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:51:08.887Z');
INSERT INTO "showing" VALUES(22,6,'trial/1',1,1,'b',1,1,'{"scene":"planes","size":"96x120","jitter":"uniform:20"}','fq4o4ejpetid_ses-1_trial-1_1.csv','{"latency_ms_median":409.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:51:18.952Z');
INSERT INTO "showing" VALUES(23,6,'trial/2',2,1,'a',1,1,'{"scene":"planes","size":"96x120","loss":0.02}','fq4o4ejpetid_ses-1_trial-2_1.csv','{"latency_ms_median":416.5,"latency_ms_sd":2.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.9,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:51:45.121Z');
INSERT INTO "showing" VALUES(24,7,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','kz98qb7pkgnc_ses-1_trial-0_1.csv','{"latency_ms_median":403.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.2,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:52:51.550Z');
INSERT INTO "showing" VALUES(25,7,'trial/1',1,1,'a',1,1,'{"scene":"planes","size":"96x120","loss":0.02}','kz98qb7pkgnc_ses-1_trial-1_1.csv','{"latency_ms_median":410.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:01.615Z');
INSERT INTO "showing" VALUES(26,7,'trial/2',2,1,'b',1,1,'{"scene":"planes","size":"96x120","jitter":"uniform:20"}','kz98qb7pkgnc_ses-1_trial-2_1.csv','{"latency_ms_median":417.5,"latency_ms_sd":3.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.8,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:53:27.784Z');
INSERT INTO "showing" VALUES(27,8,'practice',0,1,'practice',1,1,'{"scene":"planes","size":"96x120","latency":10,"warp":"none","fill":"none"}','ufhrdslj0if9_ses-1_trial-0_1.csv','{"latency_ms_median":404.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.30000000000000004,"head_still":false,"warp":"forward","size":"96x120"}','{}','2031-07-23T16:54:34.213Z');
INSERT INTO "showing" VALUES(28,8,'trial/1',1,1,'b',1,0,'{"scene":"planes","size":"96x120","jitter":"uniform:20"}','ufhrdslj0if9_ses-1_trial-1_1.csv','{}','{}','2031-07-23T16:54:44.278Z');
INSERT INTO "showing" VALUES(29,8,'trial/1',1,1,'b',2,1,'{"scene":"planes","size":"96x120","jitter":"uniform:20"}','ufhrdslj0if9_ses-1_trial-1_2.csv','{"latency_ms_median":411.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.4,"head_still":true,"warp":"forward","size":"96x120"}','{"psnr_db":28.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:54:50.317Z');
INSERT INTO "showing" VALUES(30,8,'trial/2',2,1,'a',1,1,'{"scene":"planes","size":"96x120","loss":0.02}','ufhrdslj0if9_ses-1_trial-2_1.csv','{"latency_ms_median":418.5,"latency_ms_sd":4.0,"pictures":90,"seconds":1.50000000012,"hole_share_mean":0.5,"head_still":false,"warp":"forward","size":"96x120"}','{"psnr_db":27.7,"flip":0.25,"refreshes":5,"every":10,"size":"48x60"}','2031-07-23T16:55:16.486Z');
CREATE TABLE study (name TEXT NOT NULL, made_by TEXT NOT NULL) STRICT;
INSERT INTO "study" VALUES('whole','0.2.0');
CREATE TABLE withdrawn (code TEXT NOT NULL PRIMARY KEY COLLATE NOCASE, cleaned INTEGER NOT NULL) STRICT;
CREATE INDEX event_of_session ON event (session, kind);
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('participant',8);
INSERT INTO "sqlite_sequence" VALUES('session',8);
INSERT INTO "sqlite_sequence" VALUES('event',248);
INSERT INTO "sqlite_sequence" VALUES('showing',30);
INSERT INTO "sqlite_sequence" VALUES('answer',156);
COMMIT;
