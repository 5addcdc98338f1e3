// How the page looks, on a screen and on A4.
#pragma once

namespace mwidth::cli::session {

// Colours that colour-blind readers tell apart: Okabe and Ito (2008).
inline constexpr const char* kPageStyle = R"css(
:root { --ink: #1b1f24; --soft: #5b6470; --rule: #d9dee4; --blue: #0072b2; --green: #00795a; --red: #c44e00; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem; max-width: 62rem; color: var(--ink); background: #fff;
       font: 15px/1.5 system-ui, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif; }
header { border-bottom: 2px solid var(--ink); margin-bottom: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
header p { color: var(--soft); margin: .3rem 0 .6rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; border-bottom: 1px solid var(--rule); }
h3 { font-size: 1rem; margin: 1.4rem 0 .3rem; overflow-wrap: anywhere; }
p, ul, dl { margin: .4rem 0; max-width: 48rem; }
.note { color: var(--soft); font-size: .9em; }
.warn { border-left: 4px solid var(--red); padding-left: .6rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88em; margin: .5rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .55rem; text-align: right; vertical-align: top; border-bottom: 1px solid var(--rule); }
th { font-weight: 600; vertical-align: bottom; }
thead th { border-bottom: 2px solid var(--soft); }
th.text, td.text { text-align: left; }
th.text { min-width: 6.5rem; } td.text { overflow-wrap: anywhere; }
figure { margin: .8rem 0; }
td { white-space: nowrap; } td.text, .facts td { white-space: normal; }
td small, th small { color: var(--soft); font-weight: 400; }
table.facts th { text-align: left; vertical-align: top; font-weight: 400; color: var(--soft); }
table.facts td { text-align: left; overflow-wrap: anywhere; }
dt { font-weight: 600; margin-top: .5rem; }
dd { margin: 0 0 0 1rem; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .8em; background: #f5f7f9; padding: .6rem; }
svg { max-width: 100%; height: auto; display: block; }
svg text { font: 11px system-ui, "Noto Sans", "DejaVu Sans", sans-serif; fill: var(--ink); }
svg text.note { paint-order: stroke; stroke: #fff; stroke-width: 3px; }
svg text.tick, svg text.note { fill: var(--soft); }
svg .end { text-anchor: end; } svg .middle { text-anchor: middle; }
svg path { fill: none; stroke-width: 1.4; stroke-linejoin: round; }
svg .frame { fill: none; stroke: var(--soft); stroke-width: .8; }
svg .grid { stroke: #edf0f3; stroke-width: 1; }
svg .target { stroke: var(--ink); stroke-dasharray: 6 4; }
svg .zero { stroke: var(--soft); stroke-width: .6; }
svg .moment { stroke: var(--soft); stroke-dasharray: 2 3; }
svg .fault-moment { stroke: var(--red); stroke-width: 1.5; }
svg .position { stroke: var(--blue); } svg .velocity { stroke: var(--green); }
svg .force { stroke: var(--red); } svg .mass { stroke: var(--ink); }
svg .moving { fill: #eaf3f9; } svg .trial { fill: #eaf3f9; } svg .gap { fill: #f2c9ae; }
svg .rendering { fill: #f3f8ee; } svg .fault { fill: #fbe3d6; }
.c0 { --c: #0072b2; } .c1 { --c: #d55e00; } .c2 { --c: #00795a; } .c3 { --c: #b0578d; }
.c4 { --c: #8a6d00; } .c5 { --c: #3b8ec2; } .c6 { --c: #444; }
svg .c0, svg .c1, svg .c2, svg .c3, svg .c4, svg .c5, svg .c6 { stroke: var(--c); opacity: .8; }
.key { display: inline-block; width: 1.4em; height: .25em; background: var(--c); vertical-align: middle; }
@page { size: A4; margin: 15mm; }
@media print {
  body { font-size: 10pt; max-width: none; padding: 0; }
  h2, h3 { break-after: avoid; } tr, figure, svg, .trial-part { break-inside: avoid; } thead { display: table-header-group; }
  .trial-part svg { width: auto; height: 80mm; }
  .wide { overflow: visible; } table { font-size: 7.5pt; } th, td { padding: .1rem .3rem; }
  details:not([open]) { display: none; }
}
)css";

}  // namespace mwidth::cli::session
