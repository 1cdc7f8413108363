// Serves this folder: node serve.js [PORT [FOLDER OF SCENES [FOLDER FOR PICTURES THAT PAGES SEND]]]
import { createServer } from "node:http";
import { readFile, rename, writeFile } from "node:fs/promises";
import { basename, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL(".", import.meta.url));
const port = Number(process.argv[2] ?? 8080);
const scenes = process.argv[3] ?? join(root, "scenes");
const pictures = process.argv[4];
const types = { ".html": "text/html", ".js": "text/javascript", ".json": "application/json", ".glb": "model/gltf-binary" };

async function take(request, response, path) {
  const chunks = [];
  for await (const chunk of request) chunks.push(chunk);
  const file = join(pictures, basename(path));
  await writeFile(`${file}.part`, Buffer.concat(chunks));
  await rename(`${file}.part`, file);
  response.writeHead(204).end();
}

createServer(async (request, response) => {
  try {
    // Throws where the address is not valid, as "/%".
    const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
    if (request.method === "PUT" && pictures) return await take(request, response, path);
    const file = path.startsWith("/scenes/") ? join(scenes, path.slice(8)) : join(root, path === "/" ? "index.html" : path);
    const content = await readFile(file);
    response.writeHead(200, { "content-type": types[extname(file)] ?? "application/octet-stream" });
    response.end(content);
  } catch {
    response.writeHead(404).end("not found");
  }
}).listen(port, "127.0.0.1", () => console.log(`http://127.0.0.1:${port}/`));
