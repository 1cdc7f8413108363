/** Sends the picture of a canvas to serve.js, if the page's query has ?picture=NAME. */
export async function sendPicture(canvas) {
  const name = new URLSearchParams(location.search).get("picture");
  if (!name) return;
  const picture = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  await fetch(`pictures/${name}`, { method: "PUT", body: picture });
}
