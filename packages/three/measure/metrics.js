const squares = (values) => values.reduce((sum, value) => sum + value * value, 0);
const total = (values) => values.reduce((sum, value) => sum + value, 0);
const difference = (a, b) => a.map((value, i) => value - b[i]);

export const mean = (a, b) => a.map((value, i) => (value + b[i]) / 2);

/** Root mean square difference, relative to the root mean square of the truth. */
export const rrmse = (truth, picture) => Math.sqrt(squares(difference(picture, truth)) / squares(truth));

/** How much brighter than the truth a picture is, relative to the truth. */
export const bias = (truth, picture) => total(picture) / total(truth) - 1;

/** Root mean square of what changes between two pictures beyond what changes in the truth, relative to the mean of the truth. */
export function flicker(truths, pictures) {
    const [own, change] = [truths, pictures].map(([before, after]) => difference(after, before));
    const beyond = difference(change, own);
    return Math.sqrt(squares(beyond) / beyond.length) / (total(truths[0]) / truths[0].length);
}

/** An error without the noise of its truth, which adds to it in squares. */
const without = (noise, error) => Math.sqrt(Math.max(error ** 2 - noise ** 2, 0));

/**
 * Errors of each variant in one view, without the noise of the truth: half of the difference between the halves of the truth.
 */
export function errors({ halves: [first, second], variants }) {
    const truths = first.map((picture, i) => mean(picture, second[i]));
    const noise = {
        rrmse: (0.5 * Math.sqrt(squares(difference(first[0], second[0])))) / Math.sqrt(squares(truths[0])),
        flicker: (0.5 * flicker(first, second) * total(first[0])) / total(truths[0]),
    };
    const of = (pair) => ({
        rrmse: without(noise.rrmse, rrmse(truths[0], pair[0])),
        bias: bias(truths[0], pair[0]),
        flicker: without(noise.flicker, flicker(truths, pair)),
    });
    return { noise, truth: truths[0], variants: variants.map(of) };
}
