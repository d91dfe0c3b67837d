// Khronos's validator: prints the errors and warnings of a model as JSON.
// gltf_validate.mjs FOLDER-OF-GLTF-VALIDATOR MODEL
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, dirname, join } from "node:path";

const [folder, model] = process.argv.slice(2);
const validator = createRequire(import.meta.url)(folder);
const read = (path) => new Uint8Array(readFileSync(path));
const report = await validator.validateBytes(read(model), {
  uri: basename(model),
  maxIssues: 0,
  externalResourceFunction: async (uri) => read(join(dirname(model), decodeURIComponent(uri))),
});
const { numErrors, numWarnings, messages } = report.issues;
const severe = messages.filter(({ severity }) => severity < 2);
const told = severe.map(({ code, message, pointer }) => ({ code, message, pointer }));
console.log(JSON.stringify({ errors: numErrors, warnings: numWarnings, told }));
