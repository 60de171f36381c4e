// Names as pictures that face the camera.
import { CanvasTexture, LinearFilter, Sprite, SpriteMaterial } from "three";
import type { Theme } from "../draw/theme";
import { clip, plain } from "../text";

const SIZE = 28; // [pixels] of the text
const SCALE = 0.008; // [m/pixel] at a distance of 1 m times `sizeAttenuation` off

/** Free the memory of a label. */
export function dispose({ material }: Sprite): void {
  material.map?.dispose();
  material.dispose();
}

/** Make a label. */
export function labelOf(name: string, colours: Theme): Sprite {
  const text = clip(plain(name), 60);
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  const font = `600 ${SIZE}px system-ui, sans-serif`;
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 16;
  canvas.height = SIZE + 16;
  context.font = font; // a resized canvas has forgotten it
  context.textBaseline = "middle";
  context.lineWidth = 6;
  context.lineJoin = "round";
  context.strokeStyle = colours.surface;
  context.strokeText(text, 8, canvas.height / 2);
  context.fillStyle = colours.text;
  context.fillText(text, 8, canvas.height / 2);
  const texture = new CanvasTexture(canvas);
  texture.minFilter = LinearFilter;
  const sprite = new Sprite(new SpriteMaterial({ map: texture, depthTest: false, sizeAttenuation: false }));
  sprite.center.set(0.5, 0);
  sprite.scale.set((canvas.width * SCALE) / 8, (canvas.height * SCALE) / 8, 1);
  sprite.renderOrder = 1;
  return sprite;
}
