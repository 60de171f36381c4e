// Completion and checks of YAML files, for the extension "YAML" of Red Hat where it is installed.

const { extensions, workspace } = require("vscode");

const YAML = "redhat.vscode-yaml";
const SCHEME = "seoro";
const KEY = /^([A-Za-z_][\w-]*)\s*:(?:\s|$)/gm;
const SCHEMAS = {
  campaign: require("../../../seoro/files/schemas/campaign.schema.json"),
  lab: require("../../../seoro/files/schemas/lab.schema.json"),
  policy: require("../../../seoro/files/schemas/policy.schema.json"),
  profile: require("../../../seoro/files/schemas/profile.schema.json"),
  robot: require("../../../seoro/files/schemas/robot.schema.json"),
  world: require("../../../seoro/files/schemas/world.schema.json"),
};

/** The kind of a file, by its top keys: the only schema that knows most of them and requires no others. */
function kindOf(text) {
  const keys = [...new Set([...text.matchAll(KEY)].map((found) => found[1]))];
  const fitting = Object.entries(SCHEMAS)
    .filter(([, schema]) => (schema.required ?? []).every((key) => keys.includes(key)))
    .map(([kind, schema]) => ({ kind, known: keys.filter((key) => key in schema.properties).length }))
    .filter(({ known }) => known > keys.length / 2)
    .sort((one, other) => other.known - one.known);
  return fitting.length && fitting[0].known !== fitting[1]?.known ? fitting[0].kind : undefined;
}

function requestSchema(resource) {
  const document = workspace.textDocuments.find((each) => each.uri.toString() === resource);
  const kind = document && kindOf(document.getText());
  return kind && `${SCHEME}://schema/${kind}`;
}

const requestSchemaContent = (uri) => JSON.stringify(SCHEMAS[uri.slice(uri.lastIndexOf("/") + 1)]);

async function registerSchemas() {
  const yaml = await extensions.getExtension(YAML)?.activate();
  yaml?.registerContributor(SCHEME, requestSchema, requestSchemaContent);
}

module.exports = { SCHEMAS, kindOf, registerSchemas };
