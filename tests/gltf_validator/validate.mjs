// usage: node validate.mjs FILE...   prints what the validator finds; exit code 1 where it finds an error or a warning.
import { readFileSync } from "node:fs";
import validator from "gltf-validator";

let bad = false;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)));
  const { numErrors, numWarnings, messages } = report.issues;
  bad ||= numErrors > 0 || numWarnings > 0;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
  for (const m of messages.filter((m) => m.severity < 2).slice(0, 20)) console.log(`  ${m.code} ${m.pointer ?? ""}: ${m.message}`);
}
process.exit(bad ? 1 : 0);
