"""Files of recorded tracks are read with the right units, and bad ones are refused with their line."""

import numpy as np
import pytest

from components.crowd.tracks import TrackError, read_tracks

PETRACK = """# description: made up
# framerate: 16.00
# id frame x/cm y/cm z/cm
2 8 100.0 250.0 170
1 0 -50 0 170
1 16 150 0 170
"""
OBSMAT = """ 780.0 1.0 8.46 0.0 3.59 1.67 0.0 0.05
 786.0 1.0 9.13 0.0 3.61 1.67 0.0 0.05
 786.0 3.0 -1.0 0.0 2.0 0.0 0.0 0.0
"""
CSV = """# made up
y, t, id, x, note
2.5,10.0,7,1.5,a
2.5,10.5,7,1.0,b
"""


@pytest.fixture
def read(tmp_path):
    def of(text, *, form=None, frame_rate=None, unit=None):
        path = tmp_path / "tracks.txt"
        path.write_text(text)
        return read_tracks(path, form=form, frame_rate=frame_rate, unit=unit)

    return of


def test_petrack_says_its_rate_and_its_unit(read):
    tracks = read(PETRACK)
    assert tracks.id.tolist() == [1, 2]
    assert tracks.first.tolist() == [0, 2, 3]
    assert tracks.time.tolist() == [0.0, 1.0, 0.5]
    assert tracks.position == pytest.approx(np.array([(-0.5, 0.0), (1.5, 0.0), (1.0, 2.5)]))


def test_jupedsim_says_its_unit_in_words(read):
    tracks = read("#framerate: 8\n#in m\n# ID FR X Y\n1\t0\t1.5\t2.5\n1\t8\t2.5\t2.5\n")
    assert tracks.position.tolist() == [[1.5, 2.5], [2.5, 2.5]]
    assert tracks.time.tolist() == [0.0, 1.0]


def test_obsmat_has_height_in_the_middle_and_needs_a_frame_rate(read):
    tracks = read(OBSMAT, frame_rate=15.0)
    assert tracks.id.tolist() == [1, 3]
    assert tracks.time == pytest.approx([0.0, 0.4, 0.4])
    assert tracks.position.tolist() == [[8.46, 3.59], [9.13, 3.61], [-1.0, 2.0]]


def test_csv_has_named_columns_in_any_order(read):
    tracks = read(CSV)
    assert tracks.id.tolist() == [7]
    assert tracks.time.tolist() == [0.0, 0.5]
    assert tracks.position.tolist() == [[1.5, 2.5], [1.0, 2.5]]
    assert read(CSV, unit="mm").position[0] == pytest.approx((0.0015, 0.0025))


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("", {}, "tracks.txt: no line with data"),
        ("id,t,x,y\n", {}, "no line with data after the header"),
        ("id,t,x\n1,2,3\n", {}, "tracks.txt:1: no column y in the header, found id, t, x"),
        ("# c\nid,t,x,y\n1,0,0,0\n1,1,abc,0\n", {}, "tracks.txt:4: found 'abc' as x, expected a number"),
        ("id,t,x,y\n1,0,nan,0\n", {}, "tracks.txt:2: found 'nan' as x, expected a number"),
        ("id,t,x,y\n1,0,0\n", {}, "tracks.txt:2: found 3 columns, expected at least 4"),
        ("id,t,x,y\n1.5,0,0,0\n", {}, "tracks.txt:2: id is 1.5, expected a whole number"),
        (
            "id,t,x,y\n1,0,0,0\n2,0,0,0\n\n1,0,5,5\n",
            {},
            "tracks.txt:5: id 1 is there a second time at the time of line 2",
        ),
        (CSV, {"frame_rate": 10.0}, "expected no `frame_rate`"),
        (OBSMAT, {}, "give `frame_rate`, such as 15"),
        (PETRACK, {"frame_rate": 25.0}, "the file says 16.0, but `frame_rate` is 25.0"),
        (PETRACK, {"unit": "m"}, "the file says cm, but `unit` is m"),
        ("# framerate: 8\n1 0 1 1\n", {}, "no comment says the unit"),
        ("1 0 1 1\n", {}, "tracks.txt:1: found 4 columns, expected a header"),
        ("1 0 1 1\n", {"form": "petrack"}, "does not say its frame rate; give `frame_rate`"),
    ],
)
def test_bad_files_are_refused_with_the_line(read, text, options, message):
    with pytest.raises(TrackError, match=message):
        read(text, **options)


def test_a_missing_file_says_how_to_write_it(tmp_path):
    with pytest.raises(TrackError, match="No such file.*write './name'"):
        read_tracks(tmp_path / "nix.csv", form=None, frame_rate=None, unit=None)
    (tmp_path / "picture.csv").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(TrackError, match="not a text file"):
        read_tracks(tmp_path / "picture.csv", form=None, frame_rate=None, unit=None)
