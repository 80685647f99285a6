// SPDX-License-Identifier: Apache-2.0
// Chromium without a screen, with a new, empty profile; nothing that reaches for a network on its own.
import { createRequire } from 'node:module';
import { mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

/// folder: holds node_modules. Returns the browser's context, and the profile's folder for removal.
export const emptyBrowser = async (folder, executablePath) => {
  const { chromium } = createRequire(join(folder, 'package.json'))('playwright-core');
  const profile = mkdtempSync(join(tmpdir(), 'grtx_chromium_'));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath,
    headless: true,
    viewport: { width: 1280, height: 900 },
    colorScheme: 'light',
    args: [
      '--no-sandbox',
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });
  return { context, profile };
};
