// The connection to the session: sends messages of PROTOCOL.md, receives texts and frames, and reconnects.

const retryAfter = 1000; // [ms]

export class Connection {
  // on: {open, text(message), frame(frame), lost(seconds, isFinal)}
  constructor(on) {
    this.on = on;
    this.patience = 30; // [s] until a lost server is considered to have ended
    this.number = 0;
    this.gesture = 0;
    this.waiting = new Map(); // by kind: messages to send with the next picture
    this.sentAt = new Map(); // by number [ms]
    this.connect();
  }

  connect() {
    const url = new URL('session', document.baseURI);
    url.protocol = url.protocol.replace('http', 'ws');
    const socket = (this.socket = new WebSocket(url));
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.lostAt = undefined;
      this.sentAt.clear();
      this.on.open();
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === 'string') return this.on.text(JSON.parse(data));
      const frame = readFrame(data);
      this.on.frame(frame);
    };
    socket.onclose = () => {
      this.lostAt ??= performance.now();
      const seconds = (performance.now() - this.lostAt) / 1000;
      const isFinal = seconds >= this.patience;
      this.on.lost(seconds, isFinal);
      if (!isFinal) setTimeout(() => this.connect(), retryAfter);
    };
  }

  // Reconnects after the last attempt.
  retry() {
    this.lostAt = undefined;
    this.connect();
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  newGesture() {
    return ++this.gesture;
  }

  // Sends a message. Returns its number.
  send(type, content = {}) {
    if (!this.isOpen) return 0;
    const number = ++this.number;
    this.sentAt.set(number, performance.now());
    this.socket.send(JSON.stringify({ type, number, ...content }));
    return number;
  }

  // Sends the most recent message of each kind before the next picture.
  sendSoon(type, content) {
    this.waiting.set(type + (content.object ?? content.name ?? ''), [type, content]);
  }

  flush() {
    for (const [type, content] of this.waiting.values()) this.send(type, content);
    this.waiting.clear();
  }

  shown(frame) {
    if (this.isOpen) this.socket.send(JSON.stringify({ type: 'shown', frame }));
  }

  // Returns the time since a message was sent, and forgets it and all earlier ones. [ms]
  since(number) {
    const at = this.sentAt.get(number);
    for (const old of this.sentAt.keys()) if (old <= number) this.sentAt.delete(old);
    return at === undefined ? undefined : performance.now() - at;
  }
}

// Parses a frame as described in PROTOCOL.md. Colours are views of the buffer.
export function readFrame(buffer) {
  const view = new DataView(buffer);
  const frame = {
    frame: view.getUint32(4, true),
    message: view.getUint32(8, true),
    exactness: ['moving', 'quick', 'exact'][view.getUint32(12, true)],
    milliseconds: view.getFloat32(16, true),
    objects: new Map(),
  };
  let at = 24;
  for (let count = view.getUint32(20, true); count > 0; --count) {
    const id = view.getUint32(at, true), values = 3 * view.getUint32(at + 4, true);
    const hasOver = view.getUint32(at + 8, true) === 1;
    at += 12;
    const padded = 2 * (values + (values % 2));
    const under = new Uint16Array(buffer, at, values);
    at += padded;
    const over = hasOver ? new Uint16Array(buffer, at, values) : null;
    if (hasOver) at += padded;
    frame.objects.set(id, { under, over });
  }
  return frame;
}
