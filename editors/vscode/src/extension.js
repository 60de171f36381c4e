// The extension: language server, lenses, debugger, test explorer, reports, and schemas of YAML files.

const { commands, window, workspace } = require("vscode");
const { registerDebugging } = require("./debugging");
const { registerLenses } = require("./lenses");
const { registerRunning } = require("./running");
const { registerSchemas } = require("./schemas");
const { Server } = require("./server");
const { registerTesting } = require("./testing");

const LANGUAGE = "osc";
const server = new Server(LANGUAGE);

exports.activate = async (context) => {
  const channel = window.createOutputChannel("seoro runs");
  context.subscriptions.push(
    channel,
    commands.registerCommand("seoro.restartServer", () => server.restart()),
    workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("seoro.server") && server.restart()),
    registerLenses(LANGUAGE),
    registerRunning(context, channel),
    ...registerDebugging(),
    ...registerTesting(),
  );
  await Promise.all([server.start(), registerSchemas()]);
};

exports.deactivate = () => server.stop();
