"""The look of every report: light and dark after the reader's system, and plain on paper."""

from __future__ import annotations

from typing import Final

STYLE: Final = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1c1c1e; --soft: #55565a;
  --line: #d0d1d6; --band: #f3f4f6; --link: #0b57d0;
  --s0: #0072b2; --s1: #c04a00; --s2: #00795a; --s3: #a4477f; --s4: #6b6b6b; --s5: #7a5c00; }
@media (prefers-color-scheme: dark) {
  :root { --paper: #17181b; --ink: #e8e8ea; --soft: #a8a9ae; --line: #3b3d43; --band: #212328;
  --link: #8ab4f8;
  --s0: #56b4e9; --s1: #ff9b52; --s2: #2fc79d; --s3: #e59ac8; --s4: #b0b0b0; --s5: #e2c044; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 76rem; background: var(--paper);
  color: var(--ink); font: 16px/1.5 system-ui, -apple-system, "Segoe UI", "Noto Sans",
  "Noto Sans JP", sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .5rem; }
h2 { font-size: 1.25rem; margin: 2.5rem 0 .5rem; border-top: 1px solid var(--line);
  padding-top: 1.25rem; }
h3 { font-size: 1.05rem; margin: 1.75rem 0 .25rem; }
p, ul { max-width: 46rem; }
.lead { font-size: 1.05rem; color: var(--soft); }
.scroll { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem; }
caption { text-align: left; font-weight: 600; padding: .25rem 0 .5rem; }
th, td { padding: .35rem .75rem; border-bottom: 1px solid var(--line); text-align: left;
  vertical-align: baseline; }
thead th { border-bottom: 2px solid var(--soft); font-weight: 600; }
tbody th { font-weight: 500; }
tbody tr:nth-child(even) { background: var(--band); }
.number { text-align: right; white-space: nowrap; }
.note { color: var(--soft); font-size: .88rem; max-width: 46rem; margin: .25rem 0 1rem; }
figure { margin: 1rem 0; }
figcaption { font-size: .88rem; color: var(--soft); margin-top: .35rem; }
figure img, figure svg { max-width: 100%; height: auto; display: block; }
figure img { border: 1px solid var(--line); }
.row { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(17rem, 100%), 1fr));
  gap: 1rem 1.25rem; align-items: start; }
.wide { grid-template-columns: repeat(auto-fit, minmax(min(26rem, 100%), 1fr)); }
.row figure { margin: .25rem 0; }
.scroll:focus-visible { outline: 2px solid var(--link); outline-offset: 3px; }
code, pre { font: .88rem/1.45 ui-monospace, "DejaVu Sans Mono", Consolas, monospace; }
pre { background: var(--band); padding: .75rem 1rem; white-space: pre-wrap;
  overflow-wrap: anywhere; }
svg text { fill: var(--ink); font: 12px system-ui, "Noto Sans", sans-serif; }
svg .axis { stroke: var(--soft); stroke-width: 1; fill: none; }
svg .rule { stroke: var(--line); stroke-width: 1; fill: none; }
svg .soft { fill: var(--soft); }
svg .line { fill: none; stroke-width: 2; }
.c0 { stroke: var(--s0); } .c1 { stroke: var(--s1); } .c2 { stroke: var(--s2); }
.c3 { stroke: var(--s3); } .c4 { stroke: var(--s4); } .c5 { stroke: var(--s5); }
svg .mark { fill: var(--paper); stroke-width: 2; }
svg .bar { fill: var(--band); stroke-width: 1.5; }
@media print { body { max-width: none; padding: 0; } figure, tr { break-inside: avoid; } }
"""
