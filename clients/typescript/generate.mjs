// Generates landmarkd.d.ts from the service's OpenAPI document; `npm ci` runs it after the packages are installed.

import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import openapi, { astToString } from "openapi-typescript";
import typescript from "typescript";

const here = fileURLToPath(new URL(".", import.meta.url));
const source = process.env.LANDMARKD_DOCUMENT ?? join(here, "../../openapi/landmarkd.json");

const blob = typescript.factory.createTypeReferenceNode(typescript.factory.createIdentifier("Blob"));
const nothing = typescript.factory.createLiteralTypeNode(typescript.factory.createNull());

// Bytes are a Blob in requests and answers.
const transform = (schema) => {
  if (schema.format !== "binary") return undefined;
  const nullable = Array.isArray(schema.type) && schema.type.includes("null");
  return nullable ? typescript.factory.createUnionTypeNode([blob, nothing]) : blob;
};

const work = mkdtempSync(join(tmpdir(), "landmarkd-"));
try {
  const document = join(work, "document.json");
  execFileSync("python3", [join(here, "../document.py"), source, document], { stdio: ["ignore", "ignore", "inherit"] });
  const types = astToString(await openapi(pathToFileURL(document), { transform }));
  writeFileSync(join(here, "landmarkd.d.ts"), `// Generated from the service's OpenAPI document.\n\n${types}`);
} finally {
  rmSync(work, { recursive: true });
}
