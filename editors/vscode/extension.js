// Starts `seoro lsp` and connects VS Code to it.

const { commands, window, workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

const LANGUAGE = "osc";

let client;

/** The command of the settings, with the folder of the workspace put in. */
function serverCommand() {
  const folder = workspace.workspaceFolders?.[0]?.uri.fsPath ?? "";
  const words = workspace.getConfiguration("seoro").get("server.command");
  const [command, ...args] = words.map((word) => word.replaceAll("${workspaceFolder}", folder));
  return { command, args };
}

async function start() {
  const selector = ["file", "untitled"].map((scheme) => ({ scheme, language: LANGUAGE }));
  client = new LanguageClient("seoro", "seoro", serverCommand(), { documentSelector: selector });
  try {
    await client.start();
  } catch (error) {
    window.showErrorMessage(
      `seoro: \`${serverCommand().command}\` did not start (${error?.message ?? error}). Install it with ` +
        "`pip install 'seoro[lsp]'`, and set `seoro.server.command` if it is not on the path.",
    );
  }
}

async function stop() {
  const running = client;
  client = undefined;
  if (running?.isRunning()) {
    await running.stop();
  }
}

exports.activate = async (context) => {
  const restart = async () => {
    await stop();
    await start();
  };
  context.subscriptions.push(
    commands.registerCommand("seoro.restartServer", restart),
    workspace.onDidChangeConfiguration((event) => event.affectsConfiguration("seoro.server") && restart()),
  );
  await start();
};

exports.deactivate = stop;
