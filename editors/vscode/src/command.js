// The command lines that the extension starts.

const { spawn } = require("node:child_process");
const { workspace } = require("vscode");

/** The words of a setting, with the folder of the workspace put in. */
function words(name) {
  const folder = workspace.workspaceFolders?.[0]?.uri.fsPath ?? "";
  return workspace
    .getConfiguration("seoro")
    .get(name)
    .map((word) => word.replaceAll("${workspaceFolder}", folder));
}

/** The program and the arguments of a seoro command. */
function commandLine(...args) {
  const [program, ...first] = words("command");
  return [program, [...first, ...args]];
}

/** The arguments that run a scenario, with those of the settings. */
function runArguments(file, scenario, ...more) {
  return ["exec", file, "--scenario", scenario, ...words("run.arguments"), ...more];
}

/**
 * Run a seoro command.
 *
 * @param {string[]} args Its arguments.
 * @param {{token?: import("vscode").CancellationToken, onOutput?: (text: string) => void, cwd?: string}} options
 *   Token that stops the command, and receiver of its stderr.
 * @returns {Promise<{status: number, output: string, errors: string}>} Its exit status and output.
 */
function runCommand(args, { token, onOutput, cwd } = {}) {
  const [program, all] = commandLine(...args);
  return new Promise((resolve, reject) => {
    const child = spawn(program, all, { cwd, stdio: ["ignore", "pipe", "pipe"] });
    let output = "";
    let errors = "";
    const cancelling = token?.onCancellationRequested(() => child.kill("SIGINT"));
    child.stdout.setEncoding("utf8").on("data", (text) => (output += text));
    child.stderr.setEncoding("utf8").on("data", (text) => {
      errors += text;
      onOutput?.(text);
    });
    child.on("error", (error) => {
      cancelling?.dispose();
      reject(new Error(`\`${program}\` did not start (${error.message}); set \`seoro.command\``));
    });
    child.on("close", (status) => {
      cancelling?.dispose();
      resolve({ status: status ?? -1, output, errors });
    });
  });
}

module.exports = { commandLine, runArguments, runCommand, words };
