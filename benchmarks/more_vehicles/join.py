"""A net of two trainings: the cascade of one, which proposes windows, and the looks of the other.

python benchmarks/more_vehicles/join.py CASCADE.npz LOOKS.npz OUT.npz --score-threshold SCORE
"""

import argparse
from dataclasses import replace
from pathlib import Path

from fcw.detection.net.model import NetModel


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("cascade", type=Path, help="model whose cascade is taken")
    parser.add_argument("looks", type=Path, help="model whose two looks are taken")
    parser.add_argument("out", type=Path, help="model file to write")
    parser.add_argument("--score-threshold", type=float, required=True, help="of the new model")
    arguments = parser.parse_args()
    cascade, looks = NetModel.load(arguments.cascade), NetModel.load(arguments.looks)
    replace(looks, cascade=cascade.cascade, score_threshold=arguments.score_threshold).save(arguments.out)


if __name__ == "__main__":
    main()
