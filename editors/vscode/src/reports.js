// Reports of runs in a panel.

const { readFile } = require("node:fs/promises");
const { join } = require("node:path");
const { ViewColumn, window } = require("vscode");
const { runCommand } = require("./command");

const panels = new Map();

/** Write the report of a run, and show it beside the editor. */
async function showReport(folder, title) {
  const file = join(folder, "report.html");
  const done = await runCommand(["report", folder, "-o", file]);
  if (done.status !== 0) {
    throw new Error(done.errors.trim());
  }
  let panel = panels.get(title);
  if (panel === undefined) {
    const options = { enableScripts: true, localResourceRoots: [] };
    panel = window.createWebviewPanel("seoro.report", title, { viewColumn: ViewColumn.Beside, preserveFocus: true }, options);
    panels.set(title, panel);
    panel.onDidDispose(() => panels.delete(title));
  }
  panel.webview.html = await readFile(file, "utf8");
  panel.reveal(undefined, true);
}

module.exports = { showReport };
