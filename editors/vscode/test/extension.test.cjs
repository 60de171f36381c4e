// The parts of the extension with a stand-in for VS Code, and with the real `seoro` where SEORO names it.

const assert = require("node:assert/strict");
const { mkdtempSync, writeFileSync } = require("node:fs");
const { tmpdir } = require("node:os");
const { join } = require("node:path");
const { test } = require("node:test");
const { fileUri, load } = require("./vscode.cjs");

const TEXT = 'import osc.helpers\n\nscenario good:\n    do log("hello")\n\n# scenario no:\nscenario bad:\n    do compare(1, "==", 2)\n';
const seoro = process.env.SEORO;
const real = { skip: seoro ? false : "SEORO does not name the command of seoro" };
const free = { isCancellationRequested: false, onCancellationRequested: () => ({ dispose() {} }) };

function file(text = TEXT) {
  const path = join(mkdtempSync(join(tmpdir(), "seoro-")), "main.osc");
  writeFileSync(path, text);
  return path;
}

test("scenarios are found at the left margin", () => {
  const { loaded } = load("../src/scenarios.js");
  assert.deepEqual(loaded.findScenarios(TEXT), [
    { name: "good", line: 2 },
    { name: "bad", line: 6 },
  ]);
  assert.deepEqual(loaded.findScenarios("scenario robot.drive:\r\n"), [{ name: "robot.drive", line: 0 }]);
});

test("each scenario has two lenses", () => {
  const { loaded } = load("../src/lenses.js");
  const document = { getText: () => TEXT, uri: fileUri("/work/main.osc") };
  const found = new loaded.ScenarioLenses().provideCodeLenses(document);
  assert.deepEqual(
    found.map((lens) => [lens.range.startLine, lens.command.command, lens.command.arguments[1]]),
    [
      [2, "seoro.runScenario", "good"],
      [2, "seoro.debugScenario", "good"],
      [6, "seoro.runScenario", "bad"],
      [6, "seoro.debugScenario", "bad"],
    ],
  );
});

test("the adapter is started by the command of the settings", async () => {
  const { loaded, state } = load("../src/debugging.js");
  loaded.registerDebugging();
  state.settings.command = ["${workspaceFolder}/.venv/bin/seoro", "--debug"];
  const adapter = state.factory.createDebugAdapterDescriptor();
  assert.deepEqual([adapter.command, adapter.args], ["/work/.venv/bin/seoro", ["--debug", "dap"]]);
  await state.commands["seoro.debugScenario"](fileUri("/work/main.osc"), "good");
  assert.deepEqual(state.started, [
    { type: "seoro", request: "launch", name: "good", program: "/work/main.osc", scenario: "good" },
  ]);
});

test("an empty configuration debugs the open file", () => {
  const { loaded, api, state } = load("../src/debugging.js");
  assert.equal(loaded.provider.resolveDebugConfiguration(undefined, {}), undefined);
  assert.match(state.errors[0], /open a scenario file/);
  api.window.activeTextEditor = { document: { languageId: "osc", uri: fileUri("/work/main.osc") } };
  assert.equal(loaded.provider.resolveDebugConfiguration(undefined, {}).program, "/work/main.osc");
  const given = { program: "other.osc" };
  assert.equal(loaded.provider.resolveDebugConfiguration(undefined, given), given);
});

test("steps of their own need a session", async () => {
  const { loaded, api, state } = load("../src/debugging.js");
  loaded.registerDebugging();
  await state.commands["seoro.stepToInstant"]();
  assert.match(state.errors[0], /no scenario is being debugged/);
  const sent = [];
  api.debug.activeDebugSession = { type: "seoro", customRequest: async (...args) => sent.push(args) };
  await state.commands["seoro.stepToInstant"]();
  await state.commands["seoro.stepToRecord"]();
  assert.deepEqual(sent, [
    ["seoro/step", { to: "instant" }],
    ["seoro/step", { to: "record" }],
  ]);
});

test("the test explorer has the scenarios of the workspace", async () => {
  const { loaded, state } = load("../src/testing.js");
  loaded.registerTesting();
  state.files["/work/main.osc"] = TEXT;
  state.files["/work/library.osc"] = "struct point\n";
  await state.controller.refreshHandler();
  const files = [...state.controller.items.values()];
  assert.deepEqual(files.map((item) => item.label), ["main.osc"]);
  assert.deepEqual([...files[0].children.values()].map((item) => [item.label, item.range.startLine]), [
    ["good", 2],
    ["bad", 6],
  ]);
  loaded.updateFile(state.controller, fileUri("/work/main.osc"), "");
  assert.equal(state.controller.items.size, 0);
});

test("places of failures are shown in their file only", () => {
  const { loaded } = load("../src/testing.js");
  const uri = fileUri("/work/tests/main.osc");
  const { position } = loaded.placeOf("main.osc:7:8", uri);
  assert.deepEqual([position.line, position.character], [6, 7]);
  assert.equal(loaded.placeOf("/lib/osc/helpers.osc:3:1", uri), undefined);
  assert.equal(loaded.placeOf("", uri), undefined);
});

test("a command that does not start is an error of the test", async () => {
  const { loaded, state } = load("../src/testing.js");
  state.settings.command = ["/no/such/seoro"];
  loaded.updateFile(state.controller, fileUri("/work/main.osc"), TEXT);
  await loaded.runTests(state.controller, {}, free);
  const [, errored] = state.runs[0].events;
  assert.equal(errored[0], "errored");
  assert.match(errored[2].message, /`\/no\/such\/seoro` did not start .*set `seoro.command`/);
});

test("tests run, with reasons and places", real, async () => {
  const { loaded, state } = load("../src/testing.js");
  state.settings.command = [seoro];
  state.settings["run.arguments"] = ["--clock", "virtual"];
  const uri = fileUri(file());
  loaded.updateFile(state.controller, uri, TEXT);
  await loaded.runTests(state.controller, {}, free);
  const events = state.runs[0].events.filter(([name]) => name !== "appendOutput");
  assert.deepEqual(events.map(([name, item]) => [name, item?.label]), [
    ["started", "good"],
    ["passed", "good"],
    ["started", "bad"],
    ["failed", "bad"],
    ["end", undefined],
  ]);
  assert.match(events[3][2].message, /1 == 2/);
  assert.equal(events[3][2].location.position.line, 7);
});

test("a run shows its report", real, async () => {
  const { loaded, state } = load("../src/running.js");
  state.settings.command = [seoro];
  state.settings["run.arguments"] = ["--clock", "virtual"];
  const channel = { lines: "", clear() {}, show() {}, append: (t) => (channel.lines += t), appendLine: (t) => (channel.lines += t) };
  const storage = mkdtempSync(join(tmpdir(), "seoro-"));
  await loaded.runScenario(storage, channel, fileUri(file()), "good");
  assert.match(channel.lines, /passed/);
  assert.equal(state.panels[0].title, "good: report");
  assert.match(state.panels[0].webview.html, /<html/);
});

test("files with errors are errors of the test", real, async () => {
  const { loaded, state } = load("../src/testing.js");
  state.settings.command = [seoro];
  const text = "scenario main:\n    do fly()\n";
  loaded.updateFile(state.controller, fileUri(file(text)), text);
  await loaded.runTests(state.controller, {}, free);
  const errored = state.runs[0].events.find(([name]) => name === "errored");
  assert.match(errored[2].message, /unknown scenario or action `fly`/);
});

test("the kind of a YAML file follows from its keys", () => {
  const { loaded } = load("../src/schemas.js");
  const kinds = {
    "name: hall\nextent: [-5, -5, 5, 5]\nrobots:\n  - {name: one, robot: turtlebot4}\n": "world",
    "simulators:\n  hall: {simulator: mujoco}\nrobots: {one: {in: hall}}\n": "lab",
    "urdf: robot.urdf\ndrive: differential\n": "robot",
    "model: turtlebot4\nkinds: [robot]\nbase: {limits: {linear: 1, angular: 1}}\n": "profile",
    "scenario: maze.osc\nstrategy: sobol\nruns: 10\n": "campaign",
    "everybody: {commands: 10}\n": "policy",
    "name: tests\non: push\njobs:\n  test: {runs-on: ubuntu-latest}\n": undefined,
    "services:\n  web: {image: nginx}\n": undefined,
    "": undefined,
  };
  for (const [text, kind] of Object.entries(kinds)) {
    assert.equal(loaded.kindOf(text), kind, text);
  }
});

test("schemas are given to the YAML extension where it is installed", async () => {
  const { loaded, api, state } = load("../src/schemas.js");
  await loaded.registerSchemas();
  const given = {};
  const registerContributor = (name, schema, content) => Object.assign(given, { name, schema, content });
  state.extensions["redhat.vscode-yaml"] = { activate: async () => ({ registerContributor }) };
  await loaded.registerSchemas();
  const text = "simulators:\n  hall: {simulator: mujoco}\n";
  api.workspace.textDocuments = [
    { uri: fileUri("/work/lab.yaml"), getText: () => text },
    { uri: fileUri("/work/other.yaml"), getText: () => "on: push\njobs: {}\n" },
  ];
  const uri = given.schema("file:///work/lab.yaml");
  assert.equal(given.name, new URL(uri).protocol.replace(":", ""));
  assert.deepEqual(JSON.parse(given.content(uri)), loaded.SCHEMAS.lab);
  assert.equal(given.schema("file:///work/other.yaml"), undefined);
  assert.equal(given.schema("file:///work/missing.yaml"), undefined);
});
