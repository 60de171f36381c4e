// Prints the tokens that an editor finds in the text on stdin, as JSON: for each line, [text, scopes].
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

import oniguruma from "vscode-oniguruma";
import textmate from "vscode-textmate";

const wasm = createRequire(import.meta.url).resolve("vscode-oniguruma/release/onig.wasm");
await oniguruma.loadWASM(readFileSync(wasm).buffer);
const path = new URL("../syntaxes/osc.tmLanguage.json", import.meta.url).pathname;
const registry = new textmate.Registry({
  onigLib: Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (text) => new oniguruma.OnigString(text),
  }),
  loadGrammar: async () => textmate.parseRawGrammar(readFileSync(path, "utf8"), path),
});
const grammar = await registry.loadGrammar("source.osc");
let state = textmate.INITIAL;
const lines = [];
for (const line of readFileSync(0, "utf8").split("\n")) {
  const found = grammar.tokenizeLine(line, state);
  state = found.ruleStack;
  lines.push(found.tokens.map((token) => [line.slice(token.startIndex, token.endIndex), token.scopes.slice(1)]));
}
console.log(JSON.stringify(lines));
