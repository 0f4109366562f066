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

/** Errors of the pictures of one view, and the noise of their truth: half of the difference between its halves. */
export function errors({ distance, plain, filtered, halves: [first, second] }) {
    const truths = first.map((picture, i) => mean(picture, second[i]));
    const of = (pair) => ({ rrmse: rrmse(truths[0], pair[0]), bias: bias(truths[0], pair[0]), flicker: flicker(truths, pair) });
    return {
        distance,
        plain: of(plain),
        filtered: of(filtered),
        noise: { rrmse: rrmse(first[0], second[0]) / 2, flicker: flicker(first, second) / 2 },
        truth: truths[0],
    };
}
