// The style sheet and the script of report.html.
#pragma once

namespace tetrec {

// Moves the line between photo and rendering of a view by the slider below them.
constexpr const char* kReportScript = R"js(
for (const view of document.querySelectorAll('.view')) {
  const slider = view.querySelector('.slider'), pictures = view.querySelector('.compare');
  const show = () => pictures.style.setProperty('--at', slider.value + '%');
  slider.addEventListener('input', show);
  show();
}
)js";

constexpr const char* kReportStyle = R"css(
:root{--ink:#1d2329;--soft:#5b6570;--line:#dde1e5;--paper:#fff;--card:#f6f7f8;--accent:#0b5fa5;--warn:#8a4b00;--warnpaper:#fff6e6}
@media (prefers-color-scheme:dark){:root{--ink:#e4e7ea;--soft:#9aa5b0;--line:#343b43;--paper:#15191d;--card:#1e2429;--accent:#6cb2f0;--warn:#ffcf8a;--warnpaper:#33280f}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
main{max-width:1120px;margin:0 auto;padding:28px 20px 56px}
h1{font-size:1.75rem;line-height:1.25;margin:0 0 .4rem;overflow-wrap:anywhere}
h2{font-size:1.2rem;margin:2.6rem 0 .7rem;padding-bottom:.3rem;border-bottom:1px solid var(--line)}
h3{font-size:1rem;margin:1.3rem 0 .5rem;overflow-wrap:anywhere}
p{margin:.4rem 0;max-width:75ch}
.eyebrow{color:var(--soft);font-size:.85rem;letter-spacing:.04em;text-transform:uppercase;margin:0 0 .3rem}
.verdict{font-size:1.1rem;max-width:70ch}
.note{color:var(--soft);font-size:.875rem}
.facts{display:flex;flex-wrap:wrap;gap:.15rem 1.4rem;margin:.9rem 0 0;padding:0;list-style:none;font-size:.875rem;color:var(--soft)}
.facts b{color:var(--ink);font-weight:600;overflow-wrap:anywhere}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;margin:1.4rem 0 0}
.card{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:12px 14px}
.card .value{font-size:1.6rem;font-weight:650;line-height:1.2;font-variant-numeric:tabular-nums}
.card .value small{font-size:.9rem;font-weight:500;color:var(--soft)}
.card .label{font-size:.85rem;color:var(--soft)}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.92rem}
th,td{text-align:left;padding:.38rem .9rem .38rem 0;border-bottom:1px solid var(--line);vertical-align:top}
th{font-weight:600}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.trio{display:grid;grid-template-columns:repeat(3,1fr);gap:10px}
figure{margin:0}
figcaption{font-size:.82rem;color:var(--soft);margin-top:.25rem;overflow-wrap:anywhere}
img{display:block;width:100%;height:auto;border-radius:4px;background:var(--card)}
.bar{display:flex;align-items:center;gap:10px;font-size:.82rem;color:var(--soft);margin:.7rem 0;max-width:420px}
.bar img{height:12px;flex:1;min-width:60px;border-radius:2px}
.thumbs{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:20px 14px}
.compare{--at:50%;position:relative;overflow:hidden;border-radius:4px}
.compare .over{position:absolute;inset:0;clip-path:inset(0 0 0 var(--at))}
.compare::after{content:"";position:absolute;top:0;bottom:0;left:calc(var(--at) - 1px);width:2px;background:#fff;box-shadow:0 0 2px #000}
.slider{display:block;width:100%;margin:.35rem 0;accent-color:var(--accent)}
.slider:focus-visible{outline:2px solid var(--accent);outline-offset:2px}
.pair{display:grid;grid-template-columns:1fr 1fr;gap:3px}
.strip{display:grid;grid-template-columns:repeat(6,1fr);gap:8px;margin-bottom:8px}
.plot{background:#fff;border:1px solid var(--line);border-radius:8px;padding:8px;margin-bottom:12px}
.plot img{background:#fff}
@media (prefers-color-scheme:dark){.plot{background:#171717}.plot img{background:#fff;filter:invert(.91) hue-rotate(180deg)}}
pre{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:12px 14px;font-size:.82rem;line-height:1.55;white-space:pre-wrap;overflow-wrap:anywhere}
.warnings{background:var(--warnpaper);color:var(--warn);border-radius:8px;padding:10px 14px 10px 32px;margin:0;font-size:.9rem;overflow-wrap:anywhere}
.scene{background:var(--card);border:1px solid var(--line);border-radius:8px;overflow:hidden;position:relative}
.scene canvas{display:block;width:100%;height:min(60vh,560px,95vw);min-height:260px;cursor:grab;touch-action:none}
.scene canvas[hidden]{display:none}
.scene canvas:focus-visible{outline:3px solid var(--accent);outline-offset:-3px}
.scene [role=status]{position:absolute;top:0;left:0;margin:12px 14px;color:var(--soft)}
.scene [role=status]:empty{display:none}
.scene[data-state=failed] [role=status]{position:static}
.scene[data-state=failed] .controls{display:none}
.controls{display:flex;flex-wrap:wrap;gap:.5rem 1.2rem;align-items:center;padding:10px 14px;border-top:1px solid var(--line);font-size:.9rem}
.controls select,.controls button{font:inherit;color:var(--ink);background:var(--paper);border:1px solid var(--line);border-radius:5px;padding:.15rem .4rem;max-width:12rem}
.controls input{accent-color:var(--accent)}
footer{margin-top:3rem;color:var(--soft);font-size:.82rem}
@media (max-width:640px){main{padding:18px 14px 40px}h1{font-size:1.4rem}.trio{grid-template-columns:1fr}.strip{grid-template-columns:repeat(3,1fr)}.thumbs{grid-template-columns:1fr}th,td{padding-right:.5rem;overflow-wrap:anywhere}td.n,th.n{white-space:normal}table{font-size:.82rem}}
@media print{.scene,.scene+.note{display:none}:root{--ink:#000;--soft:#444;--line:#bbb;--paper:#fff;--card:#fff;--accent:#000;--warn:#000;--warnpaper:#fff}main{max-width:none;padding:0}body{font-size:11pt}figure,.card,tr{break-inside:avoid}h2,h3{break-after:avoid}.trio{grid-template-columns:repeat(3,1fr)}}
)css";

}  // namespace tetrec
