# Shows: a small bench, read into pandas in one call, and its tables and plots for a paper.
# Writes: bench.parquet, bench.csv, bench.json, bench.html, cases, paper, best.csv

import sys
from pathlib import Path

import hmdwarp
from hmdwarp.base import PaperOptions

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/read_bench")

# As: hmdwarp bench walk --warp rotation,iterative --latency 100,200 --tables latex --plots pdf ..
hmdwarp.bench.bench(
    hmdwarp.bench.BenchOptions(
        recordings=("walk",),
        scenes=("planes",),
        warps=("rotation", "iterative"),
        fills=("none", "pyramid"),
        latencies_ms=(100.0, 200.0),
        headset="rift-dk1",
        sizes=((64, 80),),
        seconds=0.3,
        instants=2,
        workers=0,
        paper=PaperOptions(tables=("latex",), plots=("pdf",)),
        out=out,
    )
)

rows = hmdwarp.bench.read(out).to_pandas()
# Rows of one case are comparable; times only on one machine (host).
case = ["trace", "scene", "latency_ms", "host"]
best = rows.loc[rows.groupby(case)["flip"].idxmin(), [*case, "warp", "fill", "flip", "psnr_db", "total_ms"]]
best.to_csv(out / "best.csv", index=False)
rows.to_parquet(out / "bench.parquet")  # for DuckDB, R and others
print(best.to_string(index=False))

# Or with DuckDB:
#   SELECT trace, latency_ms, arg_min(warp, flip), min(flip) FROM 'bench.parquet' GROUP BY ALL;
