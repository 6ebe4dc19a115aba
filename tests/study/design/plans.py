"""A plan that has everything, small and quick to check, to be broken in tests."""

from __future__ import annotations

WHOLE = """\
schema = 1
name = "whole"
title = "Everything at once"
seed = 7
blind = "both"

[common]
scene = "planes"
size = "96x120"

[trial]
seconds = 20
repeats = 2
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
before = ["ssq"]
after = ["ssq", "vrsq"]

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
jitter = 'uniform:20'

[[family]]
name = "warped against late"
part = "run-1"
pairs = [
  ["late-200", "warped-200"],
  ["late-200", "reference"],
]
"""
