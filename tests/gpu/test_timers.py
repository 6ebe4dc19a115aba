"""Stage times: which clock, in which order, and nothing twice."""

from __future__ import annotations

import itertools

import pytest

from hmdwarp.gpu import StageTimer, check_clocks, timers


class FakeQuery:
    """Answers a fixed time, and knows whether it runs."""

    def __init__(self, elapsed: int) -> None:
        self.elapsed, self.running, self.uses = elapsed, False, 0

    def __enter__(self):
        assert not self.running
        self.running, self.uses = True, self.uses + 1

    def __exit__(self, *_):
        self.running = False


class FakeThing:
    """A buffer, or a program."""

    def release(self): ...
    def bind_to_storage_buffer(self, _): ...
    def run(self, *_): ...
    def get(self, _, missing):
        return missing


class FakeGl:
    """A context whose queries answer `elapsed` ns. finish() takes a millisecond, and as long as the
    work that waits, of its own clock."""

    def __init__(self, elapsed: int, renderer: str = "Some GPU") -> None:
        self.elapsed, self.info = elapsed, {"GL_RENDERER": renderer, "GL_MAX_COMPUTE_WORK_GROUP_COUNT": (65535,) * 3}
        self.queries: list[FakeQuery] = []
        self.now_ns = self.waiting_ns = 0
        self.buffer = self.compute_shader = lambda *_, **__: FakeThing()

    def query(self, time):
        self.queries.append(FakeQuery(self.elapsed))
        return self.queries[-1]

    def finish(self):
        self.now_ns += 1_000_000 + self.waiting_ns
        self.waiting_ns = 0


@pytest.fixture
def fake(monkeypatch):
    def make(elapsed: int, renderer: str = "Some GPU") -> FakeGl:
        gl = FakeGl(elapsed, renderer)
        monkeypatch.setattr(timers.time, "perf_counter_ns", lambda: gl.now_ns)
        return gl

    return make


CPUS = ("zink (llvmpipe (LLVM 15.0.6, 256 bits))", "llvmpipe (LLVM 19.1, 256 bits)")
REAL = {("Some GPU",): {0: False, 900: False, 1_001: True, 1_500_000: True, 1_600_000: False, 2**63: False}}
REAL |= {CPUS: {1: False, 90_000: False, 110_000: True, 900_000: True, 1_600_000: False}}


@pytest.mark.parametrize("renderers", REAL)
def test_a_timer_is_real_if_it_agrees_with_the_wall(fake, renderers):
    """By the answers, not by the renderer's name: Zink over llvmpipe has timers."""
    for renderer, (elapsed, real) in itertools.product(renderers, REAL[renderers].items()):
        gl = fake(elapsed, renderer)
        found = check_clocks(gl)
        assert (found.clock, found.wall_ms) == ("gpu" if real else "wall", 1.0)
        assert found.gpu_ms == (elapsed * 1e-6 if real else None)
        assert (f"{(1e6 - elapsed) / elapsed:+.1%}" if real else "GPU timers are unusable") in found.note


def test_the_clock_of_this_driver_is_the_one_that_measures(gpu):
    """llvmpipe's own queries answer a nanosecond; those of Zink over it are right."""
    if gpu.is_software and "Mesa 22" in gpu.version:
        assert gpu.timer.clock == ("gpu" if "zink" in gpu.renderer.lower() else "wall")


def test_gpu_stages_come_in_order_and_queries_are_used_again(fake):
    gl = fake(1_000_000)
    timer = StageTimer(gl)
    probe = len(gl.queries)
    for frame in range(5):
        for name in ("warp", "fill", "lens"):
            with timer.stage(name):
                assert gl.queries[-1].running or frame
        assert timer.collect() == [("warp", 1.0), ("fill", 1.0), ("lens", 1.0)]
        assert timer.collect() == []
    assert len(gl.queries) - probe == 3
    assert not any(query.running for query in gl.queries)


def test_wall_stages_wait_for_what_was_issued_before_and_inside(fake):
    """Earlier work, still under way, is not counted; work issued inside is waited for."""
    gl = fake(1)
    timer = StageTimer(gl)
    gl.waiting_ns = 7_000_000
    with timer.stage("warp"):
        gl.waiting_ns += 5_000_000
    with timer.stage("fill"):
        pass
    assert timer.collect() == [("warp", 6.0), ("fill", 1.0)]
    assert timer.collect() == []


def test_a_stage_that_fails_leaves_the_timer_and_its_query_usable(fake):
    for elapsed in (1, 1_000_000):
        gl = fake(elapsed)
        timer, probe = StageTimer(gl), len(gl.queries)
        for _ in range(3):
            with pytest.raises(RuntimeError, match="broken"), timer.stage("bad"):
                raise RuntimeError("broken")
        with timer.stage("good"):
            pass
        assert [name for name, _ in timer.collect()] == ["good"]
        assert len(gl.queries) - probe == (elapsed > 1) and not gl.queries[-1].running
