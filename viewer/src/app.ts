import { Data } from './data';
import { element, make, reasonOf, say } from './dom';
import type { Hooks } from './hooks';
import { MotionPage } from './motion_page';
import { openFile, withOpened } from './opened';
import type { Host } from './panels';
import { Sheet } from './sheet';
import { Stage, Theme } from './stage';

// Parts of the page that what is shown fills: each begins as page.html has it.
const FILLED = ['head', 'tools', 'names', 'files', 'objects', 'welcome', 'bar', 'sheet'];

/** The page: shows its data, opens files that are dropped on it, and is light or dark. */
export class App {
  private readonly blank = FILLED.map((id) => element(id).cloneNode(true) as HTMLElement);
  private readonly preferred = matchMedia('(prefers-color-scheme: dark)');
  private chosenTheme?: Theme;
  private stage?: Stage; // made when something is shown in 3D
  private shown?: MotionPage;
  private sheet?: Sheet;
  private back?: () => void;
  private opening: Promise<void> = Promise.resolve();

  /** @param framed in a frame of another page: it plays by itself, without controls */
  constructor(private data: Data, private readonly framed: boolean, private readonly hooks: Hooks) {
    this.preferred.addEventListener('change', () => this.themed());
    if (!framed) this.takeFiles();
    if (data.header.cards) this.showCards(0);
    else this.show(data);
  }

  /** Shows data in 3D in place of what was there. @param back leads back to the cards it is one of */
  private show(data: Data, title?: string, back?: () => void) {
    this.clear();
    this.back = back;
    if (title !== undefined) element('head').querySelector('h1')!.textContent = title;
    this.data = data;
    element('view').hidden = false;
    this.stage ??= new Stage(element<HTMLCanvasElement>('view'));
    const host: Host = {
      stage: this.stage, framed: this.framed, theme: () => this.theme, setTheme: (theme) => this.setTheme(theme), choose: () => this.choose(), back,
    };
    this.shown = new MotionPage(data, host);
    this.themed();
    Object.assign(this.hooks, this.shown.hooks());
    this.shown.begin();
  }

  /** The cards of a page of many files, scrolled to where they were. */
  private showCards(top: number) {
    this.clear();
    const cards = this.data;
    element('view').hidden = true;
    for (const id of ['head', 'tools', 'bar']) element(id).hidden = true;
    this.sheet = new Sheet(cards, {
      theme: () => this.theme,
      setTheme: (theme) => this.setTheme(theme),
      open: (one, title) => {
        const at = element('sheet').scrollTop;
        this.show(one, title, () => {
          this.data = cards;
          this.showCards(at);
        });
      },
    });
    this.themed();
    element('sheet').scrollTop = top;
    Object.assign(this.hooks, this.sheet.hooks());
  }

  private clear() {
    this.shown?.end();
    this.sheet?.end();
    this.shown = this.sheet = undefined;
    for (const part of this.blank) element(part.id).replaceWith(part.cloneNode(true));
    say('');
  }

  private get theme(): Theme {
    return this.chosenTheme ?? (this.preferred.matches ? 'dark' : 'light');
  }

  private setTheme(theme: Theme) {
    this.chosenTheme = theme;
    this.themed();
  }

  private themed() {
    document.documentElement.dataset.theme = this.theme;
    for (const button of document.querySelectorAll('#theme, #sheet-theme')) button.textContent = this.theme === 'dark' ? 'Light' : 'Dark';
    this.shown?.themed();
  }

  /** Opens files beside what is shown, one call after the other: what is dropped meanwhile waits. */
  private open(files: File[]) {
    const next = () => this.openNow(files);
    return (this.opening = this.opening.then(next, next));
  }

  /** One that cannot be read is said, and the page stays as it is. */
  private async openNow(files: File[]) {
    const title = element('head').querySelector('h1')!.textContent!;
    const refused: string[] = [];
    // Of a page of cards a file that is opened stands alone.
    let data = this.sheet ? this.data.with({ people: [], note: '' }) : this.data;
    let opened = 0;
    for (const file of files) {
      try {
        data = withOpened(data, await openFile(file, data.header.standard));
        ++opened;
      } catch (reason) {
        refused.push(reasonOf(reason));
      }
    }
    if (opened > 0) {
      const before = this.data;
      const empty = before.header.people.length === 0 && !before.header.scene;
      const cards = this.sheet && before;
      const { back } = this;
      const toCards = cards && (() => {
        this.data = cards;
        this.showCards(0);
      });
      try {
        this.show(data, empty || cards ? files.map(({ name }) => name).join(', ') : title, toCards ?? back);
      } catch (reason) { // what was there is shown again
        refused.push(reasonOf(reason));
        if (toCards) toCards();
        else this.show(before, title, back);
      }
    }
    if (refused.length > 0) say(refused.join('; '));
    this.hooks.opened = (this.hooks.opened ?? 0) + files.length;
  }

  private choose() {
    const input = make('input', { type: 'file', multiple: true, accept: '.glb,.npz' });
    input.onchange = () => void this.open([...input.files!]);
    input.click();
  }

  private takeFiles() {
    const over = (on: boolean) => (element('dropping').hidden = !on);
    addEventListener('dragover', (event) => {
      event.preventDefault();
      over(event.dataTransfer?.types.includes('Files') ?? false);
    });
    addEventListener('dragleave', (event) => event.relatedTarget === null && over(false));
    addEventListener('drop', (event) => {
      event.preventDefault();
      over(false);
      const files = [...(event.dataTransfer?.files ?? [])];
      if (files.length > 0) void this.open(files);
    });
  }
}
