# Every target does the set-up it needs first: a virtual environment in .venv, and Mesa where OpenGL is missing (.ci/setup.py).
# Settings below are changed on the command line: make replay SCENE=planes LATENCY=400

TRACE = recordings/look-around.csv
SCENE = room
LATENCY = 200
WARP = iterative
FILL = memory+pyramid
# What it is compared with: no warp, and the thesis's method on the same late frames.
AGAINST = none,forward+interpolate
# By default the headset's own.
LENS =
HEADSET = rift-dk1
OUT = out/replay
# How much of the trace, "all" for all of it; 3 seconds take less than a minute without a GPU.
SECONDS = 3
# Every n-th refresh is measured; one takes a core nearly a second with two comparisons.
METRICS_EVERY = 30
# Whatever else the command of replay or bench-quick takes, for instance OPTIONS="--seconds 2 --jitter 5".
OPTIONS =
# Of test-kill: how many sessions are killed (of sweeps a twelfth), and a seed for when; fuzz takes the seed too.
KILLS = 500
SEED = 1
# Of test-requests; its seed is SEED.
REQUESTS = 100000
# Of test-silence, with commas.
SILENT_SECONDS = 1,10,60
# Of test-soak.
SOAK_SECONDS = 3600
CROWD_SECONDS = 600
# And of stalls and cuts of a page in a browser.
WEB_ROUNDS = 3000
# Three workers, also on two cores: many tests wait for a headset's runtime, a browser or a program.
# Whichever is done first takes half of what another has left, so none works alone at the end.
PYTEST_OPTIONS = -n 3 --dist worksteal

HMDWARP = .venv/bin/hmdwarp

.PHONY: help setup replay test test-quick test-jod check check-lint check-format check-types check-shaders test-openxr test-kill test-statistics test-requests test-silence test-soak test-faults fuzz bench-quick bench-live bench-gpu site docs
.DEFAULT_GOAL = help

help:  ## show this list
	@sed -n 's/^\([a-z-]*\):.*## /  make \1 | /p' Makefile | awk -F'|' '{ printf "%-20s%s\n", $$1, $$2 }'

setup:  ## make .venv ready, with all extras (PYTHON=python3.12 chooses a Python)
	@.ci/setup

# Without extras; all other targets but test take 'setup', which has them.
replay:  ## the main job: replay a recorded head 200 ms late and report on it (SECONDS=all: all of the recording)
	@.ci/setup --base
	$(HMDWARP) replay "$(TRACE)" --scene "$(SCENE)" --latency $(LATENCY) --warp $(WARP) --fill $(FILL) \
	  $(if $(LENS),--lens $(LENS)) --headset $(HEADSET) --against "$(AGAINST)" --metrics-every $(METRICS_EVERY) --out "$(OUT)" $(if $(filter-out all,$(SECONDS)),--seconds $(SECONDS)) $(OPTIONS)

test:  ## all tests, as CI runs them; what they need beside Python comes through apt where it may
	@.ci/setup --tests
	@$(if $(CI),.venv/bin/python tests/fuzz.py --cases 1000 & fuzz=$$!;) \
	  $(if $(CI),,LEFT_OUT=last) .venv/bin/python -m pytest $(PYTEST_OPTIONS) $(if $(CI),--durations=200 --durations-min=0.5); \
	  status=$$?; $(if $(CI),wait $$fuzz || status=1;) exit $$status

test-quick: setup  ## one case of each test of the quick parts: about a minute
	@.venv/bin/python -m pytest --quick -q $(PYTEST_OPTIONS)

check: check-lint check-format check-types check-shaders  ## what pre-commit runs: ruff, its format, mypy, all shaders

check-lint: setup
	@.venv/bin/python -m ruff check --quiet

check-format: setup
	@.venv/bin/python -m ruff format --quiet --check

check-types: setup
	@.venv/bin/python -m mypy
	@.venv/bin/python -m mypy --platform win32 --cache-dir .mypy_cache/win32

check-shaders: setup
	@.venv/bin/python -m pytest -q tests/gpu/test_shader_files.py

test-jod: setup  ## those that need ColorVideoVDP, in .venv-jod beside .venv; torch is several GB
	@test -e .venv-jod/bin/python || .venv/bin/python -m venv --without-pip .venv-jod
	@.venv/bin/python -c "import sysconfig; print('import site; site.addsitedir(' + repr(sysconfig.get_path('purelib')) + ')')" \
	  >"$$(.venv-jod/bin/python -c "import sysconfig; print(sysconfig.get_path('purelib'))")/beside.pth"
	@.venv/bin/python -m pip --python .venv-jod/bin/python install --quiet --constraint .ci/constraints.txt 'hmdwarp[jod]'
	@.venv-jod/bin/python -m pytest -q tests/metrics/test_jod.py tests/study/test_measure.py $(OPTIONS)

test-openxr: setup  ## the part of them with a real OpenXR runtime; needs root and apt, builds 1.4 GB first
	@.venv/bin/python -m pytest tests/openxr $(OPTIONS)

test-kill: setup  ## kill sessions of a study at 500 random moments, damage 500 stores, kill sweeps (KILLS=, SEED=): ten minutes
	@STUDY_KILLS=$(KILLS) STUDY_DAMAGES=$(KILLS) STUDY_KILL_SEED=$(SEED) .venv/bin/python -m pytest tests/study/test_kill.py tests/study/store/test_damage.py -q $(OPTIONS)
	@SWEEP_KILLS=$$(($(KILLS) / 12)) SWEEP_KILL_SEED=$(SEED) .venv/bin/python -m pytest tests/experiments/sweep/test_kill.py -q $(OPTIONS)

test-statistics: setup  ## how often the intervals and tests of a study's analysis are right, over 150 to 400 simulated studies: two minutes
	@.venv/bin/python -m pytest tests/study/coverage.py -q $(OPTIONS)

test-requests: setup  ## 100,000 random requests to a server of the feed, all drawn (REQUESTS=, SEED=): an hour or two
	@FEED_REQUESTS=$(REQUESTS) FEED_SEED=$(SEED) .venv/bin/python -m pytest tests/sources/feed/test_any_request.py -q -k within $(OPTIONS)

test-silence: setup  ## links that fall silent and processes that are stopped for 1, 10 and 60 s (SILENT_SECONDS=): when it is told and mended
	@FEED_SILENT_SECONDS=$(SILENT_SECONDS) .venv/bin/python -m pytest tests/sources/feed/test_network.py -q -k "silent or stopped" $(OPTIONS)

test-soak: setup  ## the feed for an hour, a page for 3,000 rounds over a link that is cut and a crowd at the web's door (SOAK_SECONDS=, CROWD_SECONDS=, WEB_ROUNDS=): nothing may grow
	@.venv/bin/python docs/measure/soak_feed.py --seconds $(SOAK_SECONDS)
	@.venv/bin/python docs/measure/soak_web.py --seconds $(CROWD_SECONDS)
	@WEB_ROUNDS=$(WEB_ROUNDS) .venv/bin/python -m pytest tests/web/test_page.py -q -s -o faulthandler_timeout=0 -k stalls_and_cuts $(OPTIONS)

test-faults: setup  ## plant 166 small faults in a copy, one at a time, and say which the tests miss: hours (OPTIONS="--room poses")
	@nice -n 19 .venv/bin/python tests/faults/run.py $(OPTIONS)

fuzz: SECONDS = 120
fuzz: setup  ## damaged files of every kind through their readers for SECONDS; SEED=2 is other damage
	@.venv/bin/python tests/fuzz.py --seconds $(SECONDS) --seed $(SEED) $(OPTIONS)

bench-quick: setup  ## how long one eye takes, as ratios to OpenCV on the same frame
	@.venv/bin/python docs/measure/speed.py $(OPTIONS)

bench-live: setup  ## what a refresh of 'live' costs beside OpenGL (OPTIONS=--gc: what garbage collection does to it)
	@.venv/bin/python docs/measure/live_cost.py $(OPTIONS)

bench-gpu: OUT = out/gpu
bench-gpu: setup  ## all that is to be measured on a GPU, in at most nine minutes: $(OUT)/gpu.json and a page beside it
	@.venv/bin/python docs/measure/whole_gpu.py --out "$(OUT)" $(OPTIONS)

site: setup  ## the documentation as a site, with a reference made from docstrings: out/site/index.html
	@NO_MKDOCS_2_WARNING=1 .venv/bin/python -m mkdocs build --strict --quiet --config-file docs/site/mkdocs.yml

docs: setup  ## run what the figures and pictures in README.md and docs/ come from, and write them there
	@.venv/bin/python docs/regenerate.py $(OPTIONS)
