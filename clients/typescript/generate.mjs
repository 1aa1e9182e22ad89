// Makes landmarkd.d.ts from the service's OpenAPI document; with --check, says whether it is what would be made.
//
//     node generate.mjs [--check] landmarkd.d.ts

import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import openapi, { astToString } from "openapi-typescript";
import typescript from "typescript";

const here = fileURLToPath(new URL(".", import.meta.url));
const source = process.env.LANDMARKD_DOCUMENT ?? join(here, "../../openapi/landmarkd.json");
const check = process.argv.includes("--check");
const target = join(here, process.argv.at(-1));

const blob = typescript.factory.createTypeReferenceNode(typescript.factory.createIdentifier("Blob"));
const nothing = typescript.factory.createLiteralTypeNode(typescript.factory.createNull());

const work = mkdtempSync(join(tmpdir(), "landmarkd-"));
let made;
try {
  const document = join(work, "document.json");
  execFileSync("python3", [join(here, "../document.py"), source, document], { stdio: ["ignore", "ignore", "pipe"] });
  const nodes = await openapi(pathToFileURL(document), {
    // Bytes are a Blob, sent and received.
    transform(schema) {
      if (schema.format !== "binary") return undefined;
      const nullable = Array.isArray(schema.type) && schema.type.includes("null");
      return nullable ? typescript.factory.createUnionTypeNode([blob, nothing]) : blob;
    },
  });
  made = `// Made by "npm run generate" from the service's OpenAPI document.\n\n${astToString(nodes)}`;
} finally {
  rmSync(work, { recursive: true });
}

if (!check) {
  writeFileSync(target, made);
} else if (readFileSync(target, "utf8") !== made) {
  console.error('landmarkd.d.ts is not what the document gives: "npm run generate"');
  process.exit(1);
}
