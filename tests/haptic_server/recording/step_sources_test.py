"""The hash by which a replay knows the step again is of every source that makes a servo's scene of an object's record.

usage: step_sources_test.py [-v]
"""

import re
import unittest
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[3]
# What RecordedScenes calls, and what that calls in turn.
MAKERS = ["ServoSceneBuilder::build", "bodyPartsOf", "rigidBodyFrom", "gatherAssets"]


class StepSources(unittest.TestCase):
    def test_hold_what_makes_scenes(self):
        build = (PROJECT / "haptic_server/recording/CMakeLists.txt").read_text()
        command = re.search(r"file\(GLOB_RECURSE step_files .*?\)", build, re.S)
        patterns = re.findall(r"\$\{PROJECT_SOURCE_DIR\}/(\S+\*\S*?)\)?(?=\s|$)", command.group(0))
        hashed = {path for pattern in patterns for path in (PROJECT / pattern).parent.rglob(Path(pattern).name)}
        for maker in MAKERS:
            [source] = [path for path in (PROJECT / "haptic_server/scene").glob("*.cpp")
                        if re.search(rf"^\S[^;=]*\b{maker}\([^;]*?\{{$", path.read_text(), re.M)]
            self.assertTrue({source, source.with_suffix(".h")} <= hashed, maker)


if __name__ == "__main__":
    unittest.main()
