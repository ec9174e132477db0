// The server: what is fetched from it, and the WebSocket; orders out, words and frames in; comes back by itself.

const HEAD = 16; // bytes before the frames: name, number of the first, bytes of each

export const SILENT = "The server does not answer; is peristalsis app still running? Start it again, and open the address that it prints";

/** What the server has under a path. */
export async function ask(path) {
  const answer = await fetch(path).catch(() => { throw new Error(SILENT); });
  return answer.json();
}

export class Link {
  /** on: called with every word; frames: with (run, number of the first, frames as Float32Array); up: with whether it stands; silent: where something could not be said, or a try to come back failed. */
  constructor(token, page, { on, frames, up, silent }) {
    Object.assign(this, { token, page, on, frames, up, silent, waited: 250 });
    this.open();
  }

  open() {
    const socket = new WebSocket(`ws://${location.host}/talk?page=${this.page}`, ["peristalsis.1", `token.${this.token}`]);
    socket.binaryType = "arraybuffer";
    let stood = false;
    socket.onopen = () => { stood = true; this.waited = 250; this.up(true); };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.on(JSON.parse(data)) : this.take(data));
    socket.onclose = () => {
      this.up(false);
      if (!stood) this.silent();
      setTimeout(() => this.open(), this.waited);
      this.waited = Math.min(2 * this.waited, 8000);
    };
    this.socket = socket;
  }

  take(data) {
    const name = new TextDecoder().decode(new Uint8Array(data, 0, 8));
    const [first, size] = [8, 12].map((at) => new DataView(data).getUint32(at, true));
    const count = (data.byteLength - HEAD) / size;
    this.frames(name, first, Array.from({ length: count }, (_, k) => new Float32Array(data, HEAD + k * size, size / 4)));
  }

  say(does, content = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) { this.silent(); return false; }
    this.socket.send(JSON.stringify({ do: does, ...content }));
    return true;
  }
}
