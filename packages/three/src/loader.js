import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';

/**
 * Returns a loader of glTF models whose images may be KTX2 files, such as those that `leadr bake` writes.
 * `transcoder` is the address of the folder with three.js' `basis_transcoder.js` and `basis_transcoder.wasm`.
 */
export function modelLoader(renderer, transcoder) {
    const textures = new KTX2Loader().setTranscoderPath(transcoder).detectSupport(renderer);
    return new GLTFLoader().setKTX2Loader(textures);
}
