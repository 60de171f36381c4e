// A small stand-in for the module `vscode`, which exists inside of VS Code only. It keeps what the extension registers.

const Module = require("node:module");

class Range {
  constructor(startLine, startCharacter, endLine, endCharacter) {
    Object.assign(this, { startLine, startCharacter, endLine, endCharacter });
  }
}
class Position {
  constructor(line, character) {
    Object.assign(this, { line, character });
  }
}
class Location {
  constructor(uri, position) {
    Object.assign(this, { uri, position });
  }
}
class CodeLens {
  constructor(range, command) {
    Object.assign(this, { range, command });
  }
}
class TestMessage {
  constructor(message) {
    this.message = message;
  }
}
class DebugAdapterExecutable {
  constructor(command, args) {
    Object.assign(this, { command, args });
  }
}

class Items extends Map {
  add(item) {
    this.set(item.id, item);
  }
  replace(items) {
    this.clear();
    items.forEach((item) => this.add(item));
  }
  forEach(act) {
    [...this.values()].forEach((item) => act(item));
  }
}

const fileUri = (path) => ({ fsPath: path, toString: () => `file://${path}` });

function fresh() {
  const state = { extensions: {}, commands: {}, errors: [], panels: [], profiles: {}, started: [], runs: [], files: {}, texts: {} };
  const settings = { command: ["seoro"], "run.arguments": [], "server.command": ["seoro", "lsp"] };
  const nothing = { dispose() {} };
  const controller = {
    items: new Items(),
    createTestItem: (id, label, uri) => ({ id, label, uri, children: new Items() }),
    createRunProfile: (label, kind, handler) => (state.profiles[label] = handler),
    createTestRun: () => {
      const run = { events: [] };
      for (const name of ["started", "passed", "failed", "errored", "skipped", "appendOutput", "end"]) {
        run[name] = (...args) => run.events.push([name, ...args]);
      }
      state.runs.push(run);
      return run;
    },
  };
  state.controller = controller;
  state.settings = settings;
  const api = {
    Range, Position, Location, CodeLens, TestMessage, DebugAdapterExecutable,
    ProgressLocation: { Notification: 15 },
    TestRunProfileKind: { Run: 1, Debug: 2 },
    Uri: { file: fileUri },
    ViewColumn: { Beside: -2 },
    commands: { registerCommand: (name, act) => ((state.commands[name] = act), nothing) },
    debug: {
      activeDebugSession: undefined,
      registerDebugAdapterDescriptorFactory: (type, factory) => ((state.factory = factory), nothing),
      registerDebugConfigurationProvider: (type, provider) => ((state.provider = provider), nothing),
      startDebugging: async (folder, configuration) => state.started.push(configuration),
    },
    extensions: { getExtension: (name) => state.extensions[name] },
    languages: { registerCodeLensProvider: (selector, provider) => ((state.lenses = provider), nothing) },
    tests: { createTestController: () => controller },
    window: {
      activeTextEditor: undefined,
      showErrorMessage: (text) => state.errors.push(text),
      withProgress: (options, act) => act({}, { onCancellationRequested: () => nothing }),
      createWebviewPanel: (type, title) => {
        const panel = { title, webview: { html: "" }, onDidDispose() {}, reveal() {} };
        state.panels.push(panel);
        return panel;
      },
    },
    workspace: {
      textDocuments: [],
      workspaceFolders: [{ uri: fileUri("/work") }],
      getConfiguration: () => ({ get: (name) => settings[name] }),
      asRelativePath: (uri) => uri.fsPath.replace("/work/", ""),
      findFiles: async () => Object.keys(state.files).map(fileUri),
      fs: { readFile: async (uri) => new TextEncoder().encode(state.files[uri.fsPath]) },
      createFileSystemWatcher: () => ({ onDidCreate() {}, onDidChange() {}, onDidDelete() {}, dispose() {} }),
    },
  };
  return { api, state };
}

/** Load a module of the extension with a fresh stand-in. */
function load(path) {
  const { api, state } = fresh();
  const resolve = Module._load;
  Module._load = (name, ...rest) => (name === "vscode" ? api : resolve(name, ...rest));
  try {
    for (const known of Object.keys(require.cache).filter((each) => each.includes("/src/"))) {
      delete require.cache[known];
    }
    return { loaded: require(path), api, state };
  } finally {
    Module._load = resolve;
  }
}

module.exports = { fileUri, load };
