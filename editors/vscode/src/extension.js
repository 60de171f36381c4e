// The extension: language server, lenses, debugger, test explorer and reports.

const { commands, window, workspace } = require("vscode");
const { registerDebugging } = require("./debugging");
const { registerLenses } = require("./lenses");
const { registerRunning } = require("./running");
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
  await server.start();
};

exports.deactivate = () => server.stop();
