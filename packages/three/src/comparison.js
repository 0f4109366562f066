/**
 * Draws two scenes into one picture: the first one left of a vertical line, the second one right of it.
 * `split` is the position of the line, from 0 (left edge) to 1.
 */
export class Comparison {
    constructor(renderer, left, right) {
        this.renderer = renderer;
        this.scenes = [left, right];
        this.split = 0.5;
    }

    draw(camera) {
        const { width, height } = this.renderer.domElement;
        const ratio = this.renderer.getPixelRatio();
        // A whole number of pixels, so that the halves neither overlap nor leave a gap.
        const line = Math.round(this.split * width);
        const halves = [[0, line], [line, width]];
        this.renderer.setScissorTest(true);
        this.scenes.forEach((scene, i) => {
            const [from, to] = halves[i];
            if (to <= from) return;
            this.renderer.setScissor(from / ratio, 0, (to - from) / ratio, height / ratio);
            this.renderer.render(scene, camera);
        });
        this.renderer.setScissorTest(false);
    }
}
