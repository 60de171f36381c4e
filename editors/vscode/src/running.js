// Runs of scenarios from a lens: progress in the output channel, and the report afterwards.

const { mkdir } = require("node:fs/promises");
const { basename, dirname, join } = require("node:path");
const { ProgressLocation, Uri, commands, window } = require("vscode");
const { runArguments, runCommand } = require("./command");
const { showReport } = require("./reports");

/** The folder of the last run of a scenario. */
function folderOf(storage, file, scenario) {
  return join(storage, `${basename(file, ".osc")}-${scenario}`.replace(/[^\w.-]/g, "_"));
}

async function runScenario(storage, channel, uri, scenario) {
  const folder = folderOf(storage, uri.fsPath, scenario);
  await mkdir(storage, { recursive: true });
  channel.clear();
  channel.show(true);
  const args = runArguments(uri.fsPath, scenario, "-o", folder);
  channel.appendLine(`seoro ${args.join(" ")}`);
  const location = ProgressLocation.Notification;
  const options = { location, title: `seoro: ${scenario}`, cancellable: true };
  const done = await window.withProgress(options, (_, token) =>
    runCommand(args, { token, onOutput: (text) => channel.append(text), cwd: dirname(uri.fsPath) }),
  );
  channel.append(done.output);
  if (done.status === 0 || done.status === 1) {
    await showReport(folder, `${scenario}: report`);
  }
}

function registerRunning(context, channel) {
  const storage = (context.storageUri ?? context.globalStorageUri ?? Uri.file("/tmp")).fsPath;
  return commands.registerCommand("seoro.runScenario", async (uri, scenario) => {
    try {
      await runScenario(join(storage, "runs"), channel, uri, scenario);
    } catch (error) {
      window.showErrorMessage(`seoro: ${error.message}`);
    }
  });
}

module.exports = { folderOf, registerRunning, runScenario };
