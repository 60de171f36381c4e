// Starts `seoro lsp` and connects VS Code to it.

const { window } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");
const { words } = require("./command");

class Server {
  constructor(language) {
    this.language = language;
    this.client = undefined;
  }

  async start() {
    const [command, ...args] = words("server.command");
    const selector = ["file", "untitled"].map((scheme) => ({ scheme, language: this.language }));
    this.client = new LanguageClient("seoro", "seoro", { command, args }, { documentSelector: selector });
    try {
      await this.client.start();
    } catch (error) {
      window.showErrorMessage(
        `seoro: \`${command}\` did not start (${error?.message ?? error}). Install it with ` +
          "`pip install 'seoro[lsp]'`, and set `seoro.server.command` if it is not on the path.",
      );
    }
  }

  async stop() {
    const running = this.client;
    this.client = undefined;
    if (running?.isRunning()) {
      await running.stop();
    }
  }

  async restart() {
    await this.stop();
    await this.start();
  }
}

module.exports = { Server };
