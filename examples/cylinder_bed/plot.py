#!/usr/bin/python3
"""Pictures of runs of this bed, see examples/bed_pictures.py: plot.py RUN [RUN ...]."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]))  # `hotbed run` finds it for a case elsewhere too
from bed_pictures import main

main()
