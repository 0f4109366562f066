import { existsSync } from 'node:fs';
import { chromium } from 'playwright-core';

const FLAGS = [
    '--no-sandbox',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    '--disable-quic',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
];

/** Starts Chromium without a window, on the software renderer, with a new empty profile. `CHROMIUM` names another program. */
export async function browser() {
    const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
    if (!existsSync(executablePath)) {
        throw new Error(`${executablePath}: not found. Install the package chromium, or set CHROMIUM to a Chromium`);
    }
    return chromium.launch({ executablePath, headless: true, args: FLAGS });
}
