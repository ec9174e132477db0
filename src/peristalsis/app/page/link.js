// The WebSocket to the server: orders out, words and frames in; comes back by itself.

const HEAD = 16; // bytes before the frames: name, number of the first, bytes of each

export class Link {
  /** on: called with every word; frames: with (run, number of the first, frames as Float32Array); up: with whether it stands. */
  constructor(token, page, { on, frames, up }) {
    Object.assign(this, { token, page, on, frames, up, waited: 250 });
    this.open();
  }

  open() {
    const socket = new WebSocket(`ws://${location.host}/talk?page=${this.page}`, ["peristalsis.1", `token.${this.token}`]);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { this.waited = 250; this.up(true); };
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.on(JSON.parse(data)) : this.take(data));
    socket.onclose = () => {
      this.up(false);
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
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ do: does, ...content }));
    return true;
  }
}
