// SPDX-License-Identifier: Apache-2.0
// What was loaded is kept for a while, and given back where it takes memory.

interface Entry<T> {
  value: Promise<T>;
  holders: number;
}

// Values by their paths: those that are held, and a bounded number of others, the latest used.
export class Kept<T> {
  private readonly entries = new Map<string, Entry<T>>(); // the latest used last

  constructor(
    private readonly most: number, // that nobody holds
    private readonly load: (path: string) => Promise<T>,
    private readonly drop: (value: T) => void = () => {},
  ) {}

  // The value at a path, which isn't dropped before it is released.
  hold(path: string): { value: Promise<T>; release: () => void } {
    const entry = this.entries.get(path) ?? this.begin(path);
    this.entries.delete(path);
    this.entries.set(path, entry);
    ++entry.holders;
    return { value: entry.value, release: () => this.release(path, entry) };
  }

  get(path: string): Promise<T> {
    const { value, release } = this.hold(path);
    release();
    return value;
  }

  // Loads what has changed anew when it is asked for.
  forget(hasChanged: (path: string) => boolean) {
    for (const [path, entry] of [...this.entries]) if (hasChanged(path)) this.remove(path, entry);
  }

  private begin(path: string): Entry<T> {
    const entry = { value: this.load(path), holders: 0 };
    entry.value.catch(() => {
      if (this.entries.get(path) === entry) this.entries.delete(path);
    });
    return entry;
  }

  private release(path: string, entry: Entry<T>) {
    --entry.holders;
    if (this.entries.get(path) !== entry) return this.dropUnheld(entry);
    const idle = [...this.entries].filter(([, { holders }]) => holders === 0);
    for (const oldest of idle.slice(0, Math.max(0, idle.length - this.most))) this.remove(...oldest);
  }

  private remove(path: string, entry: Entry<T>) {
    this.entries.delete(path);
    this.dropUnheld(entry);
  }

  private dropUnheld({ value, holders }: Entry<T>) {
    if (holders === 0) value.then(this.drop, () => {});
  }
}
