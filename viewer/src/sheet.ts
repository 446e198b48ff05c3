import { chartOf } from './chart';
import type { CardData, Data } from './data';
import { element, make } from './dom';
import type { Hooks } from './hooks';
import type { Theme } from './stage';
import { Thumbnail } from './thumbnail';

export interface SheetHost {
  theme(): Theme;
  setTheme(theme: Theme): void;
  /** Shows one card in 3D. */
  open(data: Data, title: string): void;
}

const WIDTH = 480; // pixels of a thumbnail
const HEIGHT = 320;
const EVERY = 66; // milliseconds between two pictures

/** A page of many files: a card each, with a thumbnail that moves and opens in 3D, or with charts. */
export class Sheet {
  private readonly gone = new AbortController();
  private readonly thumbnails = new Map<Element, () => Thumbnail>();
  private readonly seen = new Set<Element>();
  private readonly watcher = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) this.seen.add(target);
      else this.seen.delete(target);
    }
    this.draw(true);
  }, { root: null, rootMargin: '100px' });
  private playing = !matchMedia('(prefers-reduced-motion: reduce)').matches;
  private seconds = 0;
  private pictures = 0;

  constructor(private readonly data: Data, private readonly host: SheetHost) {
    const { header } = data;
    const cards = header.cards!;
    const sheet = element('sheet');
    sheet.hidden = false;
    const theme = make('button', { type: 'button', id: 'sheet-theme', title: 'Light or dark (D)' });
    theme.onclick = () => this.toggleTheme();
    const play = make('button', { type: 'button', textContent: this.playing ? 'Pause' : 'Play', title: 'Thumbnails move or stand still (space)' });
    play.onclick = () => {
      this.playing = !this.playing;
      play.textContent = this.playing ? 'Pause' : 'Play';
    };
    play.hidden = !cards.some(({ person }) => person);
    const filter = make('input', { type: 'search', placeholder: 'Filter', ariaLabel: 'Filter cards by name' });
    filter.hidden = cards.length < 5;
    const count = make('p', { role: 'status' });
    const made = cards.map((card, i) => this.cardOf(card, i));
    filter.oninput = () => {
      const words = filter.value.toLowerCase();
      cards.forEach(({ name }, i) => (made[i].hidden = !name.toLowerCase().includes(words)));
      const left = made.filter(({ hidden }) => !hidden).length;
      count.textContent = left === cards.length ? '' : `${left} of ${cards.length}`;
    };
    sheet.append(
      make('header', {}, make('h1', { textContent: document.title }), make('p', { textContent: header.note }), make('div', { className: 'controls' }, filter, count, play, theme)),
      make('div', { className: 'cards' }, ...made));
    addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement) return;
      if (event.key.toLowerCase() === 'd') this.toggleTheme();
      else if (event.key === ' ' && !(event.target as HTMLElement).closest('button, summary') && !play.hidden) play.click();
      else return;
      event.preventDefault();
    }, { signal: this.gone.signal });
    this.run();
  }

  hooks(): Partial<Hooks> {
    return { cards: () => this.data.header.cards!.length, pictures: () => this.pictures };
  }

  /** Takes it off the page. */
  end() {
    this.gone.abort();
    this.watcher.disconnect();
  }

  private toggleTheme() {
    this.host.setTheme(this.host.theme() === 'dark' ? 'light' : 'dark');
  }

  private cardOf(card: CardData, index: number): HTMLElement {
    const { name, note, chart } = card;
    const title = make('h2', { textContent: name });
    if (chart) return make('article', { className: 'card charts' }, title, make('p', { textContent: note }), chartOf(chart));
    const canvas = make('canvas', { width: WIDTH, height: HEIGHT });
    const scene = card.scene === undefined ? undefined : this.data.header.scenes![card.scene];
    let thumbnail: Thumbnail | undefined; // made when it is first seen
    this.thumbnails.set(canvas, () => (thumbnail ??= new Thumbnail(canvas, this.data, card.person, scene, index)));
    this.watcher.observe(canvas);
    const open = make('button', { type: 'button', className: 'open', ariaLabel: `Open ${name}` }, canvas);
    open.onclick = () => this.host.open(this.data.with({ people: card.person ? [card.person] : [], scene, note }), name);
    return make('article', { className: 'card' }, open, title, make('p', { textContent: note }));
  }

  private run() {
    let before = performance.now();
    let last = 0;
    const tick = (now: number) => {
      if (this.gone.signal.aborted) return;
      if (this.playing) this.seconds += Math.min(0.1, (now - before) / 1000);
      before = now;
      if (now - last > EVERY) {
        last = now;
        this.draw(false);
      }
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** Draws the thumbnails that are in sight. */
  private draw(all: boolean) {
    if (!this.playing && !all) return;
    for (const canvas of this.seen) this.thumbnails.get(canvas)!().draw(this.seconds);
    ++this.pictures;
  }
}
