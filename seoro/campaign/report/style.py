"""Style sheet of the report: light and dark, for telephones, screens and paper."""

from typing import Final

STYLE: Final = """
:root{color-scheme:light dark;--page:#f5f6f8;--card:#fff;--text:#1b1f24;--dim:#5d6672;--line:#d9dde3;
--pass:#2b6cb0;--soft:#a9c8e8;--fail:#c2410c;--on:#fff;--code:#eef0f3}
@media(prefers-color-scheme:dark){:root{--page:#14171b;--card:#1e2228;--text:#e6e9ed;--dim:#9aa4b0;--line:#363c45;
--pass:#63a4e8;--soft:#2f5376;--fail:#f0824a;--on:#14171b;--code:#282d35}}
*{box-sizing:border-box}
body{margin:0 auto;padding:16px;max-width:1180px;background:var(--page);color:var(--text);
font:15px/1.5 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:22px;margin:4px 0 12px}h2{font-size:18px;margin:28px 0 8px}h3{font-size:15px;margin:0 0 8px}
p{margin:4px 0 10px}.dim,.note{color:var(--dim)}.note{font-size:13px}
.verdict{background:var(--card);border-left:6px solid var(--pass);border-radius:6px;padding:14px 16px;
font-size:18px}
.verdict.bad{border-color:var(--fail)}.verdict p{margin:4px 0 0;font-size:14px}
.split{display:flex;height:8px;margin:12px 0 2px;border-radius:4px;overflow:hidden;background:var(--line)}
.split i{background:var(--pass)}.split i.failed{background:var(--fail)}.split i.error{background:#8b5cf6}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(320px,100%),1fr));gap:12px}
.card{background:var(--card);border:1px solid var(--line);border-radius:6px;padding:12px;min-width:0}
.wide{margin-bottom:10px}.count{float:right;color:var(--fail);font-weight:600;margin-left:10px}
pre{background:var(--code);border-radius:4px;padding:8px 10px;margin:8px 0 0;font-size:13px;white-space:pre-wrap;
overflow-wrap:anywhere}
svg{display:block;width:100%;max-width:480px;font:12px system-ui,sans-serif}svg text{fill:var(--text)}
svg .dim{fill:var(--dim)}svg .on{fill:var(--on)}.grid{stroke:var(--line);fill:none}.range{fill:var(--soft)}
.mark,.passed{fill:var(--pass)}.failed{fill:var(--fail)}.cell{fill:var(--code)}.hit{fill:transparent}
.none{fill:none;stroke:var(--line)}
.scroll{overflow-x:auto;background:var(--card);border:1px solid var(--line);border-radius:6px;max-height:640px}
table{border-collapse:collapse;font-size:13px;width:100%}th,td{text-align:left;padding:4px 10px;vertical-align:top;
border-bottom:1px solid var(--line);max-width:340px;overflow-wrap:break-word}td.reason{min-width:200px}
th{position:sticky;top:0;background:var(--card)}td.number{text-align:right;font-variant-numeric:tabular-nums}
td.failed,td.error{color:var(--fail)}a{color:var(--pass)}summary{cursor:pointer;margin:10px 0}
dl{display:grid;grid-template-columns:max-content 1fr;gap:2px 16px;margin:0}dt{color:var(--dim)}dd{margin:0}
@media(max-width:480px){body{padding:10px}dl{grid-template-columns:1fr}dd{margin-bottom:6px}.verdict{font-size:16px}}
@media print{.scroll{max-height:none}}
"""
