// The scenarios of the workspace in the test explorer.

const { dirname } = require("node:path");
const { Location, Position, Range, TestMessage, TestRunProfileKind, debug, tests, workspace } = require("vscode");
const { runArguments, runCommand } = require("./command");
const { configurationOf } = require("./debugging");
const { findScenarios } = require("./scenarios");

const FILES = "**/*.osc";
const IGNORED = "**/{node_modules,.venv,out}/**";
const decoder = new TextDecoder();

/** Replace the scenarios of a file; a file without scenarios has no item. */
function updateFile(controller, uri, text) {
  const scenarios = findScenarios(text);
  const id = uri.toString();
  if (scenarios.length === 0) {
    controller.items.delete(id);
    return;
  }
  const file = controller.items.get(id) ?? controller.createTestItem(id, workspace.asRelativePath(uri), uri);
  controller.items.add(file);
  file.children.replace(
    scenarios.map(({ name, line }) => {
      const item = controller.createTestItem(`${id}#${name}`, name, uri);
      item.range = new Range(line, 0, line, 0);
      return item;
    }),
  );
}

async function readFiles(controller) {
  for (const uri of await workspace.findFiles(FILES, IGNORED)) {
    updateFile(controller, uri, decoder.decode(await workspace.fs.readFile(uri)));
  }
}

/** The scenarios of a request, without the excluded ones. */
function chosen(controller, request) {
  const found = [];
  const add = (item) => {
    if (request.exclude?.includes(item)) {
      return;
    }
    if (item.children.size > 0) {
      item.children.forEach(add);
    } else {
      found.push(item);
    }
  };
  if (request.include) {
    request.include.forEach(add);
  } else {
    controller.items.forEach(add);
  }
  return found;
}

/** Place of a failure, `file:line:column`, in the file of the scenario; undefined for other places. */
function placeOf(source, uri) {
  const found = /^(.*):(\d+):(\d+)$/.exec(source ?? "");
  if (found === null || !uri.fsPath.endsWith(found[1].replace(/^\.\//, ""))) {
    return undefined;
  }
  return new Location(uri, new Position(Number(found[2]) - 1, Number(found[3]) - 1));
}

/** Report the result of `seoro exec --json`. */
function report(run, item, done, duration) {
  let result;
  try {
    result = JSON.parse(done.output);
  } catch {
    run.errored(item, new TestMessage(done.errors.trim() || `seoro ended with ${done.status}`), duration);
    return;
  }
  if (result.status === "passed") {
    run.passed(item, duration);
    return;
  }
  if (result.status === "cancelled") {
    run.skipped(item);
    return;
  }
  const message = new TestMessage(result.reason || result.status);
  message.location = placeOf(result.source, item.uri);
  (result.status === "failed" ? run.failed : run.errored).call(run, item, message, duration);
}

async function runTests(controller, request, token) {
  const run = controller.createTestRun(request);
  for (const item of chosen(controller, request)) {
    if (token.isCancellationRequested) {
      run.skipped(item);
      continue;
    }
    run.started(item);
    const begun = Date.now();
    try {
      const onOutput = (text) => run.appendOutput(text.replaceAll("\n", "\r\n"), undefined, item);
      const args = runArguments(item.uri.fsPath, item.label, "--json");
      const done = await runCommand(args, { token, onOutput, cwd: dirname(item.uri.fsPath) });
      report(run, item, done, Date.now() - begun);
    } catch (error) {
      run.errored(item, new TestMessage(error.message));
    }
  }
  run.end();
}

async function debugTests(controller, request) {
  const [item] = chosen(controller, request);
  if (item !== undefined) {
    await debug.startDebugging(undefined, configurationOf(item.uri.fsPath, item.label));
  }
}

function registerTesting() {
  const controller = tests.createTestController("seoro", "Scenarios");
  controller.resolveHandler = (item) => (item === undefined ? readFiles(controller) : undefined);
  controller.refreshHandler = () => readFiles(controller);
  controller.createRunProfile("Run", TestRunProfileKind.Run, (...all) => runTests(controller, ...all), true);
  controller.createRunProfile("Debug", TestRunProfileKind.Debug, (request) => debugTests(controller, request), false);
  const watcher = workspace.createFileSystemWatcher(FILES);
  const read = async (uri) => updateFile(controller, uri, decoder.decode(await workspace.fs.readFile(uri)));
  watcher.onDidCreate(read);
  watcher.onDidChange(read);
  watcher.onDidDelete((uri) => controller.items.delete(uri.toString()));
  return [controller, watcher];
}

module.exports = { placeOf, registerTesting, report, runTests, updateFile };
