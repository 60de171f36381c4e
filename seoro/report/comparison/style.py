"""Style sheet of the page: colours of reports, light and dark, from telephones to paper."""

from typing import Final

STYLE: Final = """
:root{color-scheme:light dark;--page:#f4f5f7;--surface:#fff;--text:#1b1f24;--muted:#59626e;--line:#d5d9df;
--strong:#0b62a8;--passed:#007a5a;--failed:#b83c00;--error:#96326f;--wall:#8b939e;
--e0:#0072b2;--e1:#d55e00;--e2:#009e73;--e3:#a3588a;--e4:#b38600;--e5:#3c8fc2;--e6:#6b5b2a}
@media(prefers-color-scheme:dark){:root{--page:#12161b;--surface:#1b2027;--text:#e8ebef;--muted:#a3adb9;--line:#353d48;
--strong:#6cb8f0;--passed:#2fc99a;--failed:#ff8a4c;--error:#e48fc0;--wall:#68727f;
--e0:#56b4e9;--e1:#ff8a4c;--e2:#2fc99a;--e3:#e48fc0;--e4:#e6b422;--e5:#8ecdf2;--e6:#c9b67a}}
*{box-sizing:border-box}
body{margin:0 auto;padding:20px 16px 40px;max-width:980px;background:var(--page);color:var(--text);
font:14px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,sans-serif;overflow-wrap:anywhere}
h1{font-size:20px;line-height:1.25;margin:0 0 14px}
h2{font-size:15px;margin:24px 0 8px}.card h2,h3{font-size:14px;margin:0 0 6px}
p{margin:4px 0}.muted{color:var(--muted)}
.pair{display:grid;grid-template-columns:1fr 1fr;gap:12px}
.card{background:var(--surface);border:1px solid var(--line);border-radius:8px;padding:12px 14px;min-width:0}
.verdict{border-left:5px solid var(--muted)}.verdict.passed{border-left-color:var(--passed)}
.verdict.failed{border-left-color:var(--failed)}.verdict.error{border-left-color:var(--error)}
.letter{display:inline-block;min-width:22px;margin-right:8px;padding:0 6px;
border:1.5px solid var(--text);border-radius:5px;text-align:center;font-weight:600}.letter.b{border-style:dashed}
.status{font-weight:600}.passed .status{color:var(--passed)}.failed .status{color:var(--failed)}
.error .status{color:var(--error)}
ul{list-style:none;margin:8px 0 0;padding:0;font:13px/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}
li{padding:1px 0 1px 16px;text-indent:-16px}
.equal{border-left:5px solid var(--passed)}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;background:var(--surface);border:1px solid var(--line);border-radius:8px}
th,td{text-align:left;vertical-align:top;padding:5px 12px;border-top:1px solid var(--line);font-weight:normal}
thead th{border-top:none;color:var(--muted)}tbody th{color:var(--muted)}
td.number,th.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
.world{padding:0;overflow:hidden}
svg{display:block;width:100%;height:auto;font:12px system-ui,sans-serif}svg text{fill:var(--text)}
svg .dim{fill:var(--muted)}.wall{fill:var(--wall);opacity:.55}.bar{fill:none;stroke:var(--muted);stroke-width:1.5}
.way{fill:none;stroke:var(--text);stroke-width:2.5;stroke-linejoin:round;stroke-linecap:round}
polyline.b,path.b{stroke-dasharray:7 6}
.start,.stop.a{fill:currentColor}.stop.b{fill:var(--surface);stroke-dasharray:none}
.place{stroke-width:2}circle.place{fill:none}circle.place.b{stroke-dasharray:3 2.5}
text.place{font-weight:600;stroke:none}
.legend{display:flex;flex-wrap:wrap;gap:4px 18px;padding:8px 14px;margin:0;border-top:1px solid var(--line);
color:var(--muted)}.legend span{display:inline-flex;align-items:center;gap:6px}
.key{width:32px;height:10px;flex:none}
.e0{stroke:var(--e0);color:var(--e0)}.e1{stroke:var(--e1);color:var(--e1)}.e2{stroke:var(--e2);color:var(--e2)}
.e3{stroke:var(--e3);color:var(--e3)}.e4{stroke:var(--e4);color:var(--e4)}.e5{stroke:var(--e5);color:var(--e5)}
.e6{stroke:var(--e6);color:var(--e6)}
@media(max-width:560px){svg{font-size:22px}
body{padding:12px 10px 30px}.pair{grid-template-columns:1fr}th,td{padding:5px 8px}}
@media print{body{background:none}.card,table{break-inside:avoid}}
"""
