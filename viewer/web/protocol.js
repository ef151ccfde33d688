/* SPDX-License-Identifier: Apache-2.0 */
/* The wire: viewer/PROTOCOL.md. */

export const SUBPROTOCOL = 'lumenaut-1';
export const HEADER_SIZE = 40;
export const CAPTURE_LAYER = 255;

/* Slots of pictures; all buffers share one, the version says which was asked for. */
export const LAYERS = { neural: 0, traced: 1, error: 2, buffer: 3 };
export const PICTURES = ['neural', 'traced', 'error'];

const MEDIA_TYPES = ['image/jpeg', 'image/png', 'image/x-exr'];
const MAGIC = 0x464e4d4c; /* "LMNF", little-endian */

export function layerSlot(name) {
    return LAYERS[name] ?? LAYERS.buffer;
}

/* Header and picture of a binary message; null when it is none. */
export function readPicture(data) {
    if (!(data instanceof ArrayBuffer) || data.byteLength < HEADER_SIZE) return null;
    const view = new DataView(data);
    if (view.getUint32(0, true) !== MAGIC) return null;
    return {
        layer: view.getUint8(4),
        format: view.getUint8(5),
        isFinished: (view.getUint16(6, true) & 1) !== 0,
        frame: view.getUint32(8, true),
        version: view.getUint32(12, true),
        width: view.getUint16(16, true),
        height: view.getUint16(18, true),
        fullWidth: view.getUint16(20, true),
        fullHeight: view.getUint16(22, true),
        spp: view.getUint32(24, true),
        renderMs: view.getFloat32(28, true),
        encodeMs: view.getFloat32(32, true),
        size: data.byteLength,
        blob: new Blob([new Uint8Array(data, HEADER_SIZE)],
                       { type: MEDIA_TYPES[view.getUint8(5)] ?? 'application/octet-stream' }),
    };
}

/* What the page asks for in each mode. The error map rests until both pictures are good, so the
 * network's stands in while something moves. */
export function wantedLayers(view, isMoving) {
    if (view.mode === 'split') {
        return view.left === view.right ? [view.left] : [view.left, view.right];
    }
    if (view.mode === 'error') return isMoving ? ['error', 'neural'] : ['error'];
    return [view.mode === 'buffer' ? view.buffer : view.mode];
}

export function stateMessage(version, { values, camera, view, size, isMoving }) {
    return {
        type: 'state',
        version,
        values,
        camera,
        layers: wantedLayers(view, isMoving),
        width: size[0],
        height: size[1],
        exposure: view.exposure,
        tone: view.tone,
        moving: isMoving,
        rate: view.rate,
        least: view.least,
    };
}
