"""Pictures by leadr, kept by the contents of its binary."""
import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import files


def binary():
    found = shutil.which(os.environ.get("LEADR_BIN", "leadr"))
    if found is None:
        sys.exit("leadr was not found: set LEADR_BIN to the binary, such as target/release/leadr")
    return found


def version():
    return subprocess.run([binary(), "--version"], capture_output=True, text=True, check=True).stdout.strip()


def folder():
    """Where pictures of this binary are kept."""
    return files.OUT / ("leadr-" + hashlib.sha256(Path(binary()).read_bytes()).hexdigest()[:10])


def capture(out, panorama, camera, *flags):
    """The path of a picture, which is not drawn again if it is there."""
    path = folder() / out
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        seen = path.with_suffix(".camera.json")
        seen.write_text(json.dumps(camera))
        command = [binary(), "capture", "--environment", panorama, "--camera", seen, *flags, "-o", path, "-q"]
        subprocess.run([str(word) for word in command], check=True)
    return path


def picture(case, way, flags):
    name = f"{case.name.replace('/', '-')}-{way.replace(' ', '-')}.exr"
    return files.load(capture(name, case.panorama_file(), case.seen(), *case.flags(), *flags))
