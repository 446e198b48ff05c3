export const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

/** The button `id` shows whether it is on. */
export const press = (id: string, on: boolean) => element(id).setAttribute('aria-pressed', String(on));
