"""What the CPU does for a refresh beside the passes: calls of Python, by file and by function.

Counted by sys.setprofile around the loop of a replay that is not measured: both eyes, drawing and
link included, once all is compiled. A list comprehension and each step of a generator is a call.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import apparatus

import hmdwarp
from hmdwarp.run import RunOptions, set_up_replay

PACKAGE, GENERATED = f"{Path(hmdwarp.__file__).parent}/", "<attrs generated"


def counted(calls: Counter[tuple[str, str]]):  # noqa: ANN201 (what sys.setprofile takes)
    """Return a profiler that counts calls of functions of the package, by file and name."""

    def profile(frame, event, arg) -> None:  # noqa: ANN001
        code = frame.f_code
        if event == "call" and code.co_filename.startswith((PACKAGE, GENERATED)):
            calls[code.co_filename.removeprefix(PACKAGE), code.co_qualname] += 1

    return profile


def main() -> None:
    said = apparatus.options(
        __doc__, trace=("walk", "the head"), scene=("room", "the scene"), refreshes=(20, "how many are counted"),
        most=(12, "files, and functions, in the table"),
    )  # fmt: skip
    options = RunOptions.of(
        {
            "trace": said.trace,
            "scene": said.scene,
            "headset": "rift-dk1",
            "size": "160x200",
            "start": 4.0,
            "seconds": 1.0,
        }
    )
    of_set_up, calls, count, skipped = Counter(), Counter(), 0, 6
    sys.setprofile(counted(of_set_up))
    with set_up_replay(options) as run:
        sys.setprofile(None)
        for number, instant_ns in run.schedule.numbered():
            looks = skipped < number <= skipped + said.refreshes
            sys.setprofile(counted(calls) if looks else None)
            run.loop.draw(instant_ns)
            if number >= 0:
                run.loop.show(instant_ns)
            sys.setprofile(None)
            count += looks
    by_file = Counter()
    for (file, _), number in calls.items():
        by_file[file] += number
    print(f"calls of a refresh: {sum(calls.values()) / count:.0f}")
    written = {file for file in by_file if not file.startswith(GENERATED)}
    in_set_up = {file for file, _ in of_set_up if not file.startswith(GENERATED)}
    own = sum(file in written for file, _ in calls)
    print(f"functions: {own}, and {len(calls) - own} that attrs writes")
    print(f"files: {len(written)}; files that set-up enters: {len(in_set_up)}")
    for file, number in by_file.most_common(said.most):
        print(f"{number / count:8.1f}  {file}")
    print("functions")
    for (file, name), number in calls.most_common(said.most):
        print(f"{number / count:8.1f}  {file}: {name}")


if __name__ == "__main__":
    main()
