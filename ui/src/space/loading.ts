// The world in three dimensions is loaded when it is wanted: it is larger than all other views.
import type { RunModel } from "../data/model";

/** A picture of a run that can be turned. Distances are in pixels. */
export interface Picture {
  resize(width: number, height: number): void;
  show(time: number): void;
  turn(right: number, up: number): void;
  shift(right: number, up: number): void;
  zoom(factor: number): void;
  fit(): void;
  dispose(): void;
}

export type MakePicture = (canvas: HTMLCanvasElement, run: RunModel, map: HTMLCanvasElement | null) => Picture;

declare global {
  var seoroWorld3D: MakePicture | undefined;
}

let address = "";

/** Load it from an address of the server; reports contain it. */
export function loadSpaceFrom(url: string): void {
  address = url;
}

/** Whether the page can show runs in three dimensions. */
export function hasSpace(): boolean {
  return address !== "" || document.documentElement.dataset["space"] !== undefined;
}

/** Load it. Raises an error if this is not possible. */
export async function loadSpace(): Promise<MakePicture> {
  if (globalThis.seoroWorld3D === undefined && address !== "") {
    await new Promise<void>((resolve, reject) => {
      const script = document.createElement("script");
      script.src = address;
      script.onload = () => resolve();
      script.onerror = () => reject(new Error("the connection is lost"));
      document.head.append(script);
    });
  }
  if (globalThis.seoroWorld3D === undefined) throw new Error("the page is incomplete");
  return globalThis.seoroWorld3D;
}
