import { bvhOf } from './bvh';
import type { Data } from './data';
import { element, make, reasonOf, save, say } from './dom';
import type { Gallery } from './gallery';
import type { Menu } from './menu';
import type { Person } from './person';
import type { Stage } from './stage';

/** What a motion page needs of the page that it is on. */
export interface Host {
  stage: Stage;
  /** In a frame of another page: it plays by itself, without controls. */
  framed: boolean;
  theme(): 'light' | 'dark';
  setTheme(theme: 'light' | 'dark'): void;
  /** Lets the visitor choose files to open. */
  choose(): void;
  /** Back to the cards that this was one of. */
  back?(): void;
}

interface Shown {
  people: Person[];
  gallery?: Gallery;
  hasObjects: boolean;
  /** The view, just drawn. */
  picture(): HTMLCanvasElement;
  time(): number;
}

const TOUCH: [string, string][] = [
  ['drag', 'Orbit; with the right button, or two fingers, move'],
  ['wheel', 'Zoom; on a touch screen pinch'],
  ['drop', 'Open a .glb or .npz file'],
];

/** Without what file systems do not like in names. */
const fileName = (name: string) => name.replace(/[^\p{L}\p{N}._-]+/gu, '_').slice(0, 80);

/** The panels of files and objects, the help, and what is saved. */
export class Panels {
  /** Panels that buttons open, one at a time, and the help. */
  constructor(menu: Menu, private readonly host: Host, private readonly data: Data, private readonly shown: Shown) {
    const panels = [['list', 'objects', 'o'], ['file', 'files', 'e']] as const;
    const show = (which: string, on: boolean) => {
      for (const [button, panel] of panels) {
        const here = on && panel === which;
        element(panel).hidden = !here;
        element(button).setAttribute('aria-expanded', String(here));
      }
    };
    for (const [button, panel, key] of panels) {
      show(panel, false);
      menu.press(button, key, () => show(panel, !element(button).hidden && element(panel).hidden === true));
    }
    element('list').hidden = !shown.hasObjects;
    element('open').onclick = element('choose').onclick = () => host.choose();
    menu.press('picture', 'p', () => void this.savePicture());
    const people = shown.gallery || shown.people.length > 8 ? [] : shown.people;
    for (const person of people) this.addSaving(`Save motion${people.length > 1 ? ` of ${person.data_.name}` : ''} .bvh`, () => person);
    if (people.length === 0 && shown.people.length > 0) {
      this.addSaving('Save motion .bvh (of who is chosen, or the first)', () => shown.gallery?.picked ?? shown.people.find(({ enabled }) => enabled) ?? shown.people[0]);
    }
    const first = element('motions').querySelector('button');
    if (first) {
      first.title = 'Save the motion as .bvh (M)';
      menu.on('m', () => first.click());
    }
    menu.press('helper', '?', () => {
      menu.explain(element('help').querySelector('dl')!, TOUCH);
      element<HTMLDialogElement>('help').showModal();
    });
    const { back } = host;
    element('back').hidden = !back;
    if (back) element('back').onclick = () => back();
  }

  private addSaving(label: string, who: () => Person) {
    const button = make('button', { type: 'button', textContent: label });
    button.onclick = () => {
      const { data_ } = who();
      try {
        save(`${fileName(data_.name || 'motion')}.bvh`, new Blob([bvhOf(this.data, data_)], { type: 'text/plain' }));
      } catch (reason) {
        say(reasonOf(reason));
      }
    };
    element('motions').append(button);
  }

  /** What is seen now, without the controls. */
  private async savePicture() {
    const view = this.shown.picture();
    const picture = await new Promise<Blob | null>((done) => view.toBlob(done, 'image/png'));
    if (!picture) return say('The picture could not be made');
    save(`${fileName(element('head').querySelector('h1')!.textContent || 'inhabit')}-${this.shown.time().toFixed(2)}s.png`, picture);
  }

  /** Closes what is open: a panel, a message, or the card that this is. */
  escape() {
    const open = ['objects', 'files'].filter((panel) => !element(panel).hidden);
    if (open.length > 0) {
      for (const panel of open) element(panel === 'objects' ? 'list' : 'file').click();
    } else if (!element('message').hidden) say('');
    else this.host.back?.();
  }
}
