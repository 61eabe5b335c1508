"""A report says what was found, no more and no less, whatever the file calls its channels."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from base64 import b64decode
from collections.abc import Iterator
from dataclasses import replace
from hashlib import sha256
from html.parser import HTMLParser
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import control
import matplotlib
import numpy as np
import pytest
from jsonschema import Draft202012Validator
from matplotlib.figure import Figure
from PIL import Image

import suspid
from suspid import (
    Considered,
    Identification,
    InputError,
    Reconstruction,
    add_noise,
    eigenmodes,
    free_decay,
    grip,
    identify,
    quarter_car,
    reconstruct,
    ride,
    sensitivities,
)
from suspid.analysis import analyse
from suspid.cleaning import Cleaned, Finding
from suspid.decays import Decay
from suspid.identification import identification_to_dict, identify_repeats, to_json, verdict_of
from suspid.identification.modes_json import read_modes
from suspid.records import as_response
from suspid.reporting import Source, content_of, json_schema, report, report_to_dict, source_of
from suspid.reporting.axes import shown
from suspid.reporting.colours import Colour
from suspid.reporting.numerals import quantity
from suspid.reporting.page_text import sentence_html
from suspid.reporting.pictures import NARROW, Picture, Pictures, pictures_of
from suspid.reporting.record_facts import record_facts, view_of
from suspid.reporting.rows import pole_rows
from suspid.reporting.spring_rows import spring_rows
from suspid.reporting.svg import page_style, svg_of
from suspid.reporting.thinning import MOST_SAMPLES, drawable, is_whole
from suspid.signals import as_signal
from suspid.units import RealArray
from suspid.words import (
    DecayDoubt,
    Defect,
    ModeCheck,
    NextStep,
    Number,
    Reason,
    ReconstructionCheck,
    RecordCheck,
    Remark,
)
from validation import cars

HOSTILE = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "$\\frac{",
    "'-->]]>&lt;{{ 7 * 7 }}",
    "\x1b[2J\x00\u202eq",
    "",
    "a" * 400,
)
SOURCE = Source(
    file="decay <b>.csv",
    sha256="ab" * 32,
    size=1_234_567,
    command="suspid report 'decay <b>.csv' -o report.html",
    created="2026-01-02 03:04 UTC",
)


def stretch(start: float, stop: float, *, kind: Any = None, cycles: float = 5.0, doubts: tuple[str, ...] = ()) -> Decay:
    """Return a decay as a recording has it."""
    wn, zeta = np.array([10.0]), np.array([0.1])
    return Decay(
        start=start,
        stop=stop,
        rank=1,
        kind=kind,
        level=40.0,
        cycles=cycles,
        strength=60.0,
        wn=wn,
        zeta=zeta,
        doubts=tuple(Remark(DecayDoubt.NOT_IDENTIFIED, {"error": text}) for text in doubts),
    )


def codes_of(content: dict[str, Any]) -> set[str]:
    return {check["code"] for check in content["verdict"]["checks"]}


def level_of(content: dict[str, Any]) -> str:
    return str(content["verdict"]["level"])


class Page(HTMLParser):
    """The tags of a page, the values of their attributes, and its text by table cell."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.said: list[str] = []
        self.cells: list[str] = []
        self.open = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag in ("td", "th"):
            self.cells.append("")
            self.open = True

    def handle_endtag(self, tag: str) -> None:
        self.open = self.open and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        self.said.append(data)
        if self.open:
            self.cells[-1] += data

    @property
    def text(self) -> str:
        return "".join(self.said)


def paper_record(*, snr_db: float = 20.0, duration: float = 10.0, seed: int = 1) -> control.TimeResponseData:
    decay = free_decay(cars.PAPER, np.arange(0, duration, 0.005), initial_state={"v_tire": 1.0})
    return add_noise(decay, snr_db=snr_db, rng=np.random.default_rng(seed))


def renamed(record: control.TimeResponseData, names: tuple[str, ...]) -> control.TimeResponseData:
    """Return a record of as many channels as names, each a mixture of those given."""
    signal = as_signal(record)
    mixture = np.random.default_rng(7).normal(size=(len(names), len(signal.values)))
    noise = 1e-5 * np.random.default_rng(8).normal(size=(len(names), signal.values.shape[1]))
    return as_response(signal.timepts, mixture @ signal.values + noise, names)


def still(*, channels: int = 2) -> control.TimeResponseData:
    return as_response(
        np.arange(1500) / 100, np.random.default_rng(2).normal(size=(channels, 1500)), list("xyzuvw")[:channels]
    )


@pytest.fixture(scope="module", autouse=True)
def drawn_once() -> Iterator[None]:
    """Draw the pictures of one identification once: most tests read the words beside them."""
    kept: dict[object, tuple[object, Pictures]] = {}

    def once(found: Identification, *, decays: tuple[Decay, ...], units: tuple[str, ...], **how: Any) -> Pictures:
        drawing = import_module("suspid.reporting.pictures").svg_of
        key = (
            id(found),
            tuple(map(id, decays)),
            units,
            tuple(sorted((k, id(v)) for k, v in how.items())),
            drawing is svg_of,
        )
        if key not in kept:  # what is kept beside the pictures keeps its identity
            kept[key] = (found, decays, how), pictures_of(found, decays=decays, units=units, **how)
        return kept[key][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("suspid.reporting.report"), "pictures_of", once)
        yield


@pytest.fixture(scope="module")
def found() -> Identification:
    return identify(paper_record(), candidates=[4.0, 8.0, 16.0])


@pytest.fixture(scope="module")
def hostile() -> Identification:
    return identify(renamed(paper_record(snr_db=40.0), HOSTILE), candidates=[4.0, 16.0])


@pytest.fixture(scope="module")
def springs(found: Identification) -> Reconstruction:
    return reconstruct(found.modes, cars.PAPER)


@pytest.fixture(scope="module")
def nothing() -> Identification:
    return identify(still(), candidates=[4.0])


@pytest.fixture(scope="module")
def long() -> Identification:
    t = np.arange(1_000_000) / 1000
    decay = np.exp(-0.05 * t) * np.cos(2 * np.pi * 3 * t) + 0.01 * np.random.default_rng(0).normal(size=t.size)
    decay[654_321] = 0.9
    return identify(as_response(t, decay[None], ["y"]))


@pytest.fixture(scope="module")
def pictures(found: Identification) -> Pictures:
    return drawn(found)


def finding(*, channel: str = "seat", kind: Defect = Defect.SLOWER_CLOCK, repaired: bool = True) -> Finding:
    numbers: dict[str, Number] = {"level": 9.8, "range": 1.0, "rate": 2.0, "onto": 100.0, "channels": (channel,)}
    remark = Remark(kind, numbers)
    return Finding(remark=remark, channel=channel, start=1.0, stop=1.5, samples=3, repaired=repaired)


def drawn(found: Identification) -> Pictures:
    return pictures_of(
        found, cleaned=None, decays=(), units=("m",) * len(as_signal(found.response).channels), used=None
    )


def every(pictures: Pictures) -> list[str]:
    """Return all pictures, narrow and wide."""
    one = [pictures.scalogram, *([pictures.entropy] if pictures.entropy else [])]
    several = [*(p for pair in pictures.fits for p in pair), *pictures.shapes, *pictures.skeletons, *pictures.overviews]
    return [svg for p in (*one, *several) for svg in (p.narrow, p.wide) if svg]


def paths(svg: str, colour: str) -> list[RealArray]:
    """Return the corners of all lines of a colour [pt], (corner, 2)."""
    found = [
        node.attrib["d"] for node in ElementTree.fromstring(svg).iter("path") if colour in node.attrib.get("style", "")
    ]
    return [points(path) for path in found]


def points(path: str) -> RealArray:
    """Return the corners of a path of one piece."""
    start, steps = re.fullmatch(r"M(\S+ \S+?)l(.*)", path).groups()  # type: ignore[union-attr]
    numbers = np.array([*start.split(), *steps.split()], float).reshape(-1, 2)
    return np.cumsum(numbers, axis=0)


@pytest.mark.usefixtures("words_alone")
class TestVerdict:
    """What each check says has its own tests; here is that the page and the JSON show them."""

    def test_an_identification_has_its_own_verdict(self, found: Identification, nothing: Identification) -> None:
        for each in (found, nothing):
            assert report_to_dict(each)["verdict"] == json.loads(json.dumps(verdict_of(each).to_dict()))

    def test_the_page_says_headline_level_and_every_check(self, found: Identification, nothing: Identification) -> None:
        for each in (found, nothing):
            verdict, text = verdict_of(each), Page(report(each)).text
            for said in (
                str(verdict.headline).capitalize(),
                verdict.meaning,
                *map(str, verdict.doubts + verdict.support),
            ):
                assert said in text

    def test_noise_holds_no_mode_and_the_page_says_why(self, nothing: Identification) -> None:
        assert str(ModeCheck.NOTHING_DECAYS.words) in Page(report(nothing)).text

    def test_an_offset_left_alone_is_harmless(self, found: Identification) -> None:
        offset = finding(kind=Defect.OFFSET, repaired=False)
        cleaned = Cleaned(record=found.response, units=("m",) * 3, findings=(offset,))
        assert level_of(report_to_dict(content_of(found, cleaned=cleaned))) == level_of(report_to_dict(found))

    def test_repeats_that_agree_speak_for_it(self, found: Identification) -> None:
        once, again = (as_signal(paper_record(duration=6.0, seed=seed)) for seed in (1, 2))
        values = np.asarray(np.concatenate([once.values, again.values], axis=1), np.float64)
        both = as_response(np.arange(values.shape[1], dtype=np.float64) * once.step, values, once.channels)
        repeats = identify_repeats(both, [(0.0, 5.9), (6.0, 11.9)])
        text = Page(report(content_of(found, repeats=repeats))).text
        assert "6 … 11.9" in text
        assert "2 decays agree" in text
        assert "the first of 2 decays" in text
        assert "decay 2" in text
        content = report_to_dict(content_of(found, repeats=repeats))
        Draft202012Validator(json_schema("report")).validate(content)
        assert ModeCheck.REPEATS_AGREE.value in codes_of(content)
        apart = replace(repeats, consistency=tuple(replace(a, widening=2.0) for a in repeats.consistency))
        assert ModeCheck.REPEATS_DISAGREE.value in codes_of(report_to_dict(content_of(found, repeats=apart)))

    def test_doubts_about_the_decay_and_the_recording_count(self, found: Identification) -> None:
        defects = (finding(repaired=False), finding(repaired=False))
        cleaned = Cleaned(record=found.response, units=("m",) * 3, findings=defects)
        content = report_to_dict(
            content_of(found, cleaned=cleaned, decays=(stretch(0.0, 10.0, doubts=("only 1.5 cycles",)),))
        )
        assert level_of(content) == "doubtful"
        assert {RecordCheck.DECAY.value, RecordCheck.DEFECTS.value} <= codes_of(content)

    def test_a_car_that_does_not_explain_the_modes_counts(self, found: Identification, springs: Reconstruction) -> None:
        content = report_to_dict(content_of(found, reconstruction=replace(springs, explains=False)))
        assert ReconstructionCheck.UNEXPLAINED.value in codes_of(content)
        assert level_of(content) != "sound"

    def test_an_analysis_brings_everything(self) -> None:
        analysis = analyse(paper_record(), car=cars.PAPER)
        content = report_to_dict(analysis)
        Draft202012Validator(json_schema("report")).validate(content)
        assert content["verdict"] == json.loads(json.dumps(analysis.verdict.to_dict()))
        parts = report_to_dict(
            content_of(
                analysis.identification,
                cleaned=analysis.cleaned,
                decays=analysis.decays,
                repeats=analysis.repeats,
                reconstruction=analysis.reconstruction,
            )
        )
        assert content == parts
        assert "Springs and dampers" in Page(report(analysis)).text

    def test_a_car_is_judged_on_bench_and_road(self, found: Identification, springs: Reconstruction) -> None:
        driven = ride(springs, road="C", speed=20.0)
        content = content_of(found, reconstruction=springs, ride=driven)
        plain = report_to_dict(content)
        Draft202012Validator(json_schema("report")).validate(plain)
        assert plain["grip"]["wheels"][0]["phase_rad"] == grip(springs).phase[0]  # type: ignore[index]
        text = Page(report(content)).text
        assert "Wheels on a test bench" in text
        value = driven["seat_acceleration.Wk"]
        low, _ = driven.interval(0.95)["seat_acceleration.Wk"]
        assert quantity(value, value - low).value in text
        assert report_to_dict(found)["grip"] is None
        assert "test bench" not in Page(report(found)).text

    def test_what_moves_what_stands_in_the_page(self, found: Identification, springs: Reconstruction) -> None:
        """Names, values and the strongest parameter of each row are those of `sensitivities`."""
        content = content_of(found, reconstruction=springs, ride=ride(springs, road="C", speed=20.0))
        expected = sensitivities(springs.suspension, road="C", speed=20.0, bench=True)
        plain = report_to_dict(content)["sensitivities"]
        assert plain["names"] == list(expected.names)  # type: ignore[index]
        text = Page(report(content)).text
        row = expected.elasticity[expected.names.index("seat_acceleration.Wk")]
        at = int(np.argmax(np.abs(row)))
        assert f"{expected.parameters[at]} {row[at]:+.2f}".replace("-", "−") in text
        assert "suspid tune found.toml --road C --speed 20" in text
        assert "seat_acceleration.Wk" in text
        assert "m/s²" in text
        assert "m/s2" not in text
        assert report_to_dict(found)["sensitivities"] is None


TEMPLATES = Path(suspid.__file__).parent / "reporting" / "templates"


class TestTables:
    @pytest.mark.parametrize("template", sorted(TEMPLATES.glob("*.j2")), ids=lambda path: path.name)
    def test_every_cell_has_its_label_where_a_phone_hides_the_headings(self, template: Path) -> None:
        cells = re.findall(r"<td\b[^>]*>", template.read_text(encoding="utf-8"))
        assert [cell for cell in cells if "data-label=" not in cell] == []


@pytest.mark.usefixtures("words_alone")
class TestRounding:
    @pytest.mark.parametrize("seed", range(40))
    def test_value_and_interval_are_rounded_together(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        reach = float(10 ** rng.uniform(-8, 4))
        value = float(reach * 10 ** rng.uniform(0, 5) * rng.choice([-1, 1]))
        shown = quantity(value, reach)
        written = float(shown.value.replace("−", "-"))
        # Two digits of the interval are to within 5 in 100 of the least, 10; the value is to half of its last digit.
        assert float(shown.reach) == pytest.approx(reach, rel=0.05)
        unit = 10.0 ** np.floor(np.log10(float(shown.reach)) - 1 + 1e-9)
        assert abs(written - value) <= 0.5 * unit * (1 + 1e-6) + 1e-12 * abs(value)
        decimals = [len(text.partition(".")[2]) for text in (shown.value, shown.reach)]
        assert decimals[0] == decimals[1]

    @pytest.mark.parametrize(("reach", "said"), [(0.0996, "0.10"), (0.0994, "0.099"), (9.96, "10"), (349.6, "350")])
    def test_an_interval_has_two_digits(self, reach: float, said: str) -> None:
        assert quantity(1.0, reach).reach == said

    def test_without_an_interval_there_is_none(self) -> None:
        assert quantity(1.0, None).reach == ""
        assert quantity(1.0, float("nan")).reach == ""

    def test_the_page_shows_the_intervals_of_the_modes(self, found: Identification) -> None:
        cells = Page(report(found)).cells
        ends = found.modes.interval(0.95)
        for k, wn in enumerate(found.modes.wn):
            for value, reach in (
                (wn / (2 * np.pi), (ends.wn[k, 1] - wn) / (2 * np.pi)),
                (wn, ends.wn[k, 1] - wn),
                (found.modes.zeta[k], ends.zeta[k, 1] - found.modes.zeta[k]),
            ):
                shown = quantity(float(value), float(reach))
                assert f"{shown.value} ± {shown.reach}" in [cell.strip() for cell in cells]

    def test_the_page_shows_what_is_known_of_the_channels(self, found: Identification) -> None:
        """Shares in percent, noise with three digits; the record ends at its last sample, not one step behind it."""
        text = " ".join(Page(report(found)).cells)
        signal = as_signal(found.response)
        for name, share, noise in zip(signal.channels, found.explained, found.noise_std, strict=True):
            numbers = re.search(rf"{re.escape(name)} (?:–|\S+) (\S+) (\S+) ", text)
            assert numbers, name
            assert float(numbers[1]) == pytest.approx(100 * share, abs=0.005)
            assert float(numbers[2]) == pytest.approx(noise, rel=0.005)
        assert record_facts(found)["end"] == f"{signal.timepts[-1]:.6g} s"

    @pytest.mark.parametrize("level", [0.5, 0.99])
    def test_the_json_has_the_intervals_of_the_level(
        self, found: Identification, springs: Reconstruction, level: float
    ) -> None:
        said: Any = report_to_dict(content_of(found, reconstruction=springs, level=level))
        ends = found.modes.interval(level)
        for k, mode in enumerate(said["quality"]):
            assert mode["wn_interval_rad_per_s"] == pytest.approx(ends.wn[k])
            assert mode["frequency_interval_hz"] == pytest.approx(ends.wn[k] / (2 * np.pi))
            assert mode["zeta_interval"] == pytest.approx(ends.zeta[k])
            assert mode["halves_apart_std"] == found.halves[k]
        for row in said["reconstruction"]["parameters"]:
            assert (row["lower"], row["upper"]) == pytest.approx(springs.interval(level)[row["name"]])

    def test_significant_is_what_the_level_of_the_page_makes_it(self, springs: Reconstruction) -> None:
        """Three and a half standard deviations from nominal are no chance at 95 %, and may be at 99.99 %."""
        std = float(np.sqrt(springs.covariance[0, 0])) if springs.covariance is not None else np.nan
        strut, quantity_ = springs.parameters[0].split(".")
        assert quantity_ == "stiffness"
        low, high = springs.interval(0.95)[springs.parameters[0]]
        other = springs.suspension.with_parameters(stiffness={strut: (low + high) / 2 + 3.5 * std})
        rows = {level: spring_rows(replace(springs, nominal=other), level)[0].significant for level in (0.95, 0.9999)}
        assert rows == {0.95: "yes", 0.9999: "no"}

    def test_every_spring_has_its_interval(self, found: Identification, springs: Reconstruction) -> None:
        text = " ".join(Page(report(content_of(found, reconstruction=springs))).cells)
        for name, (low, high) in springs.interval(0.95).items():
            numbers = re.search(rf"{re.escape(name)} (?:N/m|N s/m) (\S+) (\S+) ± (\S+) (\S+) %", text)
            assert numbers, name
            nominal, value, reach, change = (float(part.replace("−", "-")) for part in numbers.groups())
            # Each is rounded by half of the interval's second digit: a twentieth of it at most.
            assert (value - reach, value + reach) == pytest.approx((low, high), abs=0.11 * reach)
            assert change == pytest.approx(100 * ((low + high) / 2 / nominal - 1), abs=0.051)


@pytest.mark.usefixtures("words_alone")
class TestWhatDecides:
    def test_a_tick_says_what_was_tested_and_a_note_what_changed(self, found: Identification) -> None:
        names = [f"{strut.name}.{what}" for strut in cars.PAPER.struts for what in ("stiffness", "damping")]
        other = cars.PAPER.with_parameters(
            stiffness={strut.name: 1.3 * strut.stiffness for strut in cars.PAPER.struts},
            damping={strut.name: 2.5 * strut.damping for strut in cars.PAPER.struts},
        )
        springs = reconstruct(found.modes, other)
        said = "\n".join(map(str, springs.verdict.support))
        assert "With the springs and dampers found, the car explains the modes" in said
        assert "as described" not in said
        (changed,) = (c.remark for c in springs.verdict.checks if c.remark.code is ReconstructionCheck.CHANGED)
        assert changed.numbers["names"] == springs.parameters
        assert sorted(springs.parameters) == sorted(names)
        assert [row.significant for row in spring_rows(springs, 0.95)] == ["yes"] * 6
        kept = reconstruct(found.modes, springs.suspension)
        assert not [c for c in kept.verdict.checks if c.remark.code is ReconstructionCheck.CHANGED]

    def test_the_car_file_is_in_the_page_and_in_the_json(
        self, found: Identification, springs: Reconstruction, tmp_path: Path
    ) -> None:
        path = tmp_path / "car <b>.toml"
        path.write_text(Path("examples/nominal_car.toml").read_text())
        content = content_of(found, reconstruction=springs, car=source_of(path, text=True))
        assert path.read_text().strip() in Page(report(content)).text
        car: Any = report_to_dict(content)["car"]
        assert car == {"file": path.name, "sha256": sha256(path.read_bytes()).hexdigest(), "toml": path.read_text()}
        assert "[[struts]]" in str(report_to_dict(content_of(found, reconstruction=springs))["car"])

    def test_there_is_always_a_next_step(self, found: Identification, nothing: Identification) -> None:
        assert [step.code for step in content_of(found).steps] == [NextStep.USE, NextStep.GIVE_CAR]
        assert content_of(nothing).steps[0].code is NextStep.RECORD_A_DECAY

    def test_rejected_poles_have_a_row_for_each_reason(self, found: Identification) -> None:
        pole = Considered(pole=-1 + 60j, remark=Remark(Reason.NOT_NEEDED), removed=False)
        many = tuple(replace(pole, pole=-1 + 60j * (k + 1)) for k in range(16))
        tone = replace(pole, remark=Remark(Reason.TONE), removed=True)
        rows = pole_rows(replace(found, considered=(*many, tone)))
        assert [row.number for row in rows] == [16, 1]
        assert rows[0].frequency.startswith("9.551, 19.10, ")

    @pytest.mark.parametrize(("seconds", "said"), [(6.0, "It is computed at"), (60.0, "it shows the first")])
    def test_what_is_said_of_the_scalogram_is_true(self, seconds: float, said: str) -> None:
        t = np.arange(0, seconds, 1 / 7000)
        decay = np.exp(-8 / seconds * t) * np.cos(2 * np.pi * 40 * t)
        if seconds > 10:
            decay = np.exp(-4 * t) * np.cos(2 * np.pi * 40 * t)
        noise = 1e-3 * np.random.default_rng(0).normal(size=t.size)
        view = view_of(drawable(identify(as_response(t, (decay + noise)[None], ["y"]), modes=1, bandwidth=8.0)))
        assert said in str(view["shown"])
        for first in re.findall(r"first (\S+) s,", str(view["shown"])):
            assert float(first) < seconds


class TestOptions:
    def test_they_stay_on_one_line_and_markup_stays_text(self) -> None:
        shown = str(sentence_html("<b>name it (--wheel-radius 0.3) or --lateral; a--b and x - y"))
        assert shown.count('<span class="option">') == 2
        assert '<span class="option">--wheel-radius</span> 0.3' in shown
        assert "<b>" not in shown


class TestNames:
    def test_whatever_the_file_holds_stays_text(self, hostile: Identification) -> None:
        cleaned = Cleaned(
            record=hostile.response,
            units=tuple(f"<u>{i}" for i in range(len(HOSTILE))),
            findings=(finding(channel=HOSTILE[0]), finding(channel=HOSTILE[1])),
        )
        decays = (stretch(0.0, 9.0, kind=HOSTILE[0], doubts=(HOSTILE[1],)),)
        text = report(
            content_of(hostile, source=SOURCE, cleaned=cleaned, decays=decays, warnings=[HOSTILE[0]]), title=HOSTILE[1]
        )
        page = Page(text)
        assert "script" not in page.tags
        assert not {"b", "u"} & {tag for tag, _, value in page.attributes if value} - {"b"}
        assert not [name for _, name, _ in page.attributes if name.startswith("on")]
        assert "img" not in page.tags
        assert {value[:22] for tag, name, value in page.attributes if (tag, name) == ("image", "href")} == {
            "data:image/png;base64,"
        }
        for name in HOSTILE[:4]:
            assert name in page.text
        assert r"\x1b[2J\x00\u202eq" in page.text
        assert "\x1b" not in text
        assert "\u202e" not in text
        assert "49" not in page.text.split("{{ 7")[1][:20]

    @pytest.mark.slow
    def test_the_whole_of_a_long_name_stands_in_the_table(self, hostile: Identification) -> None:
        assert HOSTILE[-1] in [cell.strip() for cell in Page(report(hostile)).cells]


class TestSelfContained:
    def test_nothing_is_fetched(self, found: Identification) -> None:
        text = report(content_of(found, source=SOURCE))
        page = Page(text)
        assert not {"script", "link", "iframe", "object", "embed"} & set(page.tags) - {"link"}
        for tag, name, value in page.attributes:
            if name in ("src", "href", "srcset", "data", "action", "poster"):
                assert value.startswith(("data:", "#")), (tag, name, value[:40])
        assert "@import" not in text
        # Parts of the pictures refer to each other: clip paths.
        assert set(re.findall(r"url\(.", text)) <= {"url(#"}
        (policy,) = [v for tag, n, v in page.attributes if tag == "meta" and n == "content" and "default-src" in v]
        assert policy.startswith("default-src 'none';")

    def test_the_same_input_gives_the_same_bytes(self, found: Identification) -> None:
        again = identify(paper_record(), candidates=[4.0, 8.0, 16.0])
        assert report(content_of(found, source=SOURCE)) == report(content_of(again, source=SOURCE))

    def test_it_says_where_it_comes_from(self, found: Identification, tmp_path: Path) -> None:
        path = tmp_path / "decay.csv"
        path.write_bytes(b"abc")
        source = source_of(path, command="suspid report decay.csv", created="2026-01-01")
        # The example of FIPS 180-2.
        assert source.sha256 == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        text = Page(report(content_of(found, source=source))).text
        for said in (source.sha256, "decay.csv", "3 bytes", source.command, source.created, f"numpy {np.__version__}"):
            assert said in text

    def test_an_unreadable_file_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="cannot be read"):
            source_of(tmp_path / "none.csv", command="", created="")


@pytest.mark.usefixtures("words_alone")
class TestWhatIsThere:
    def test_all_that_was_given_is_shown(self, found: Identification, springs: Reconstruction) -> None:
        whole = paper_record(duration=12.0)
        cleaned = Cleaned(record=whole, units=("m", "mm", ""), findings=(finding(), finding(repaired=False)))
        decays = (stretch(3.0, 5.0, doubts=("only 1.5 cycles",)), stretch(0.0, 10.0))
        text = Page(report(content_of(found, cleaned=cleaned, decays=decays, reconstruction=springs))).text
        for said in (
            "'seat' at 2 Hz, the others at 100 Hz; left out",
            "1 defect of the recording was found and not repaired",
            "Stretch 2 of 2 was used",
            "only 1.5 cycles",
            "Chi-square",
            "tire.stiffness",
        ):
            assert said in text

    def test_a_cut_by_hand_is_none_of_the_decays(self, found: Identification) -> None:
        assert "is none of these stretches" in Page(report(content_of(found, decays=(stretch(4.0, 5.0),)))).text

    def test_twins_stand_beside(self, found: Identification, springs: Reconstruction) -> None:
        twin = cars.PAPER.with_parameters(stiffness={"tire": 123456.0})
        both = replace(springs, alternatives=(twin,), distances=(2.5,), told_apart=("75 kg on the seat",))
        text = Page(report(content_of(found, reconstruction=both))).text
        for said in ("other 1", "123460", "chi-square 2.5; distinguished by 75 kg on the seat"):
            assert said in text

    def test_the_ridge_method(self) -> None:
        found = identify(paper_record(), method="ridge", candidates=[8.0])
        text = Page(report(found)).text
        assert "ridges of the wavelet transform" in text
        assert len(found.modes) == 3

    def test_real_poles(self) -> None:
        car = quarter_car(
            chassis_mass=400, tire_mass=40, chassis_stiffness=20e3, tire_stiffness=200e3, chassis_damping=12e3
        )
        assert "real" in eigenmodes(car).kinds
        record = free_decay(car, np.arange(0, 3, 0.002), initial_state={"z_chassis": 0.1})
        found = identify(add_noise(record, snr_db=60, rng=np.random.default_rng(0)), candidates=[1.0, 2.0])
        assert "real" in found.modes.kinds
        assert "overdamped: one real pole" in Page(report(found)).text

    @pytest.mark.parametrize("count", [1, 12, pytest.param(30, marks=pytest.mark.slow)])
    def test_any_number_of_channels(self, count: int) -> None:
        names = tuple(f"channel {k}" for k in range(count))
        found = identify(renamed(paper_record(duration=4.0), names), candidates=[4.0])
        page = report(found)
        text = Page(page).text
        assert ("Mode shapes" in text) == (count > 1)
        for name in names:
            assert name in text
        assert len(page.encode()) < 2e6


@pytest.mark.slow
class TestLongRecords:
    def test_the_page_stays_small(self, long: Identification) -> None:
        assert len(report(long).encode()) < 2e6

    def test_no_peak_gets_lost(self, long: Identification) -> None:
        (whole, _), *_ = drawn(drawable(long)).fits
        (record,) = paths(whole.narrow, "--pale")
        values = as_signal(long.response).values[0]
        # Right and down go straight with time and value: the first and the largest sample give the scale.
        top, left = record[np.argmin(record[:, 1])], record[0]
        assert values.max() == pytest.approx(values[0], rel=0.05)
        spike = record[np.argmin(np.abs(record[:, 0] - left[0] - 0.654321 * np.ptp(record[:, 0])))]
        scale = np.ptp(record[:, 1]) / np.ptp(values)
        # A path has steps of a tenth of a point; three of them are rounded.
        assert spike[1] - top[1] == pytest.approx((values.max() - 0.9) * scale, abs=0.3)

    def test_the_view_keeps_the_modes(self, long: Identification) -> None:
        view = drawable(long)
        assert view.steps.signal.values.size <= MOST_SAMPLES
        assert not is_whole(view)
        (ridge,) = view.ridges
        # The ridge is the mode: to five of its own standard deviations, as of any record.
        (fit,) = view.lines
        assert abs(fit.pole - long.modes.poles[0]) < 5 * np.sqrt(2 * fit.variance)
        assert ridge.window.stop > 20
        assert drawable(view) is view

    def test_a_short_record_keeps_its_own(self, found: Identification) -> None:
        assert drawable(found) is found

    def test_ridges_of_a_short_record_are_those_of_identify(self) -> None:
        """The default candidates, whose best lies between the few of long records."""
        t = np.arange(0, 6, 0.01)
        noise = 1e-3 * np.random.default_rng(0).normal(size=t.size)
        found = identify(as_response(t, (np.exp(-0.4 * t) * np.cos(20 * t) + noise)[None], ["y"]), modes=1)
        said: Any = report_to_dict(found)
        plain = json.loads(to_json(identification_to_dict(found, file="", warnings=[])))
        assert said["ridges"] == plain["ridges"]
        assert said["wavelet"]["bandwidth"] == found.scalogram.wavelet.bandwidth


class TestPictures:
    def test_a_line_is_where_its_samples_are(self) -> None:
        x, y = np.linspace(2, 4, 300), np.sin(np.linspace(0, 6, 300))
        with page_style():
            figure = Figure(figsize=(4, 3))
            ax = figure.add_axes((0.25, 0.25, 0.5, 0.5), xlim=(2, 4), ylim=(-1.5, 1.5))
            ax.plot(x, y, color=Colour.BLUE)
            (at,) = paths(svg_of(figure, name="line", described="A line"), "--blue")
        # 4 by 3 inches are 288 by 216 points; matplotlib drops corners that lie on a line to a ninth of a pixel.
        height = np.interp(at[:, 0], 72 + 72 * (x - 2), 54 + 36 * (1.5 - y))
        assert np.allclose(at[:, 1], height, rtol=0, atol=0.2)
        assert at[0, 0] == pytest.approx(72, abs=0.05)
        assert at[-1, 0] == pytest.approx(216, abs=0.05)

    @pytest.mark.parametrize("name", HOSTILE)
    def test_a_name_stays_a_name(self, name: str) -> None:
        with page_style():
            figure = Figure()
            figure.subplots().set_title(shown(f'{name} id="text_1" #0072b2 url(#a)'[-60:], most=60))
            root = ElementTree.fromstring(svg_of(figure, name="title", described="A title"))
        assert 'id="text_1" #0072b2 url(#a)' in "".join(node.text or "" for node in root.iter("text"))
        assert {node.tag for node in root.iter()} <= {"svg", "g", "path", "text", "use", "defs"}

    def test_every_identifier_stands_once(self, hostile: Identification) -> None:
        page = Page(report(hostile))
        identifiers = [value for _, name, value in page.attributes if name == "id"]
        assert len(identifiers) == len(set(identifiers))
        references = {m for _, _, value in page.attributes for m in re.findall(r"^(?:url\()?#([\w-]+)", value)}
        assert len(references) > 10
        assert references <= set(identifiers)

    def test_every_colour_has_a_dark_counterpart(self, found: Identification) -> None:
        whole = Cleaned(record=paper_record(duration=12.0), units=("m",) * 3, findings=())
        decays = (stretch(3.0, 5.0), stretch(0.0, 10.0))
        pictures = pictures_of(found, cleaned=whole, decays=decays, units=("m",) * 3, used=1)
        text = " ".join(every(pictures))
        assert not re.findall(r"#[0-9a-f]{6}", text)
        names = set(re.findall(r"var\(--([\w-]+)\)", text))
        assert len(names) > 8
        assert names <= {colour.css for colour in Colour}

    @pytest.mark.slow
    def test_the_same_picture_whatever_the_users_style(self, found: Identification, pictures: Pictures) -> None:
        with matplotlib.rc_context({"lines.linewidth": 9.0, "font.size": 30.0, "svg.fonttype": "path"}):
            assert drawn(found) == pictures
            assert matplotlib.rcParams["font.size"] == 30.0

    def test_the_scalogram_is_loudest_at_the_mode(self) -> None:
        t = np.arange(0, 20, 0.01)
        found = identify(as_response(t, (np.exp(-0.1 * t) * np.cos(2 * np.pi * 5 * t))[None], ["y"]), modes=1)
        svg = drawn(found).scalogram.narrow
        root = ElementTree.fromstring(svg)
        (picture,) = root.iter("image")
        # The picture is stored upside down: it is moved by its height and turned over.
        (shift,) = re.findall(r"^scale\(1 -1\) translate\(0 (-?[\d.]+)\)", picture.attrib["transform"])
        top, height = float(picture.attrib["y"]) + float(shift), float(picture.attrib["height"])
        content = b64decode(picture.attrib["href"].partition(",")[2])
        shades = np.asarray(Image.open(BytesIO(content)).convert("L"), float)
        darkest = float(np.mean(np.flatnonzero(shades.min(axis=1) == shades.min()))) + 0.5
        (ridge,) = paths(svg, "--vermilion")
        assert ridge[0, 1] == pytest.approx(ridge[-1, 1], abs=0.1)
        # A row of the scalogram is a few points high.
        assert -(top + darkest / len(shades) * height) == pytest.approx(ridge[0, 1], abs=3.0)

    def test_a_picture_is_described(self, pictures: Pictures) -> None:
        for svg in every(pictures):
            root = ElementTree.fromstring(svg)
            assert root.attrib["role"] == "img"
            assert len(root.attrib["aria-label"]) > 10

    def test_every_picture_has_axes_with_units(self, pictures: Pictures) -> None:
        for svg in every(pictures):
            texts = ["".join(node.itertext()) for node in ElementTree.fromstring(svg).iter("text")]
            assert sum(bool(re.search(r"\[.+\]$", text)) for text in texts) >= 1

    def test_a_power_of_ten_stands_beside_the_unit(self, found: Identification) -> None:
        shown = pictures_of(found, cleaned=None, decays=(), units=["m"] * 3, used=None)
        assert "[10⁻³ m]" in "".join(every(shown))

    def test_pictures_fit_a_phone_at_their_size(self, pictures: Pictures) -> None:
        narrow: list[Picture] = [pictures.scalogram, *pictures.shapes, *pictures.skeletons]
        for picture in narrow:
            box = ElementTree.fromstring(picture.narrow).attrib["viewBox"].split()
            assert float(box[2]) == pytest.approx(72 * NARROW)


@pytest.mark.usefixtures("words_alone")
class TestJson:
    def everything(self, found: Identification, springs: Reconstruction | None) -> dict[str, object]:
        cleaned = Cleaned(record=found.response, units=("",) * 7, findings=(finding(),))
        few = replace(cleaned, units=("m",) * len(as_signal(found.response).channels))
        return report_to_dict(
            content_of(
                found,
                source=SOURCE,
                cleaned=few,
                decays=(stretch(0.0, 1.0, cycles=float("nan"), doubts=("short",)),),
                reconstruction=springs,
                warnings=["a warning"],
            )
        )

    def test_it_obeys_its_schema(
        self, found: Identification, hostile: Identification, nothing: Identification, springs: Reconstruction
    ) -> None:
        schema = json_schema("report")
        Draft202012Validator.check_schema(schema)
        validator = Draft202012Validator(schema)
        twin = replace(springs, alternatives=(cars.PAPER,), distances=(0.5,), told_apart=("x",))
        for content in (
            self.everything(found, twin),
            self.everything(hostile, None),
            report_to_dict(nothing),
            report_to_dict(identify(paper_record(), method="ridge", candidates=[8.0])),
        ):
            validator.validate(content)
            json.dumps(content, allow_nan=False)

    def test_what_it_does_not_know_is_refused(self, found: Identification) -> None:
        validator = Draft202012Validator(json_schema("report"))
        content = report_to_dict(found)
        assert not validator.is_valid(content | {"more": 1})
        assert not validator.is_valid({key: value for key, value in content.items() if key != "verdict"})

    def test_every_field_is_described(self) -> None:
        def walk(node: object, where: str) -> None:
            if isinstance(node, dict):
                if "type" in node or "const" in node or "enum" in node:
                    assert node.get("description"), where
                if "properties" in node:
                    assert node.get("additionalProperties") is False, where
                for key, value in node.items():
                    if key == "properties":
                        for name, child in value.items():
                            walk(child, f"{where}.{name}")
                    elif key in ("items", "additionalProperties"):
                        walk(value, f"{where}[]")

        walk(json_schema("report"), "report")

    def test_it_is_read_as_modes(self, found: Identification, tmp_path: Path) -> None:
        path = tmp_path / "report.json"
        path.write_text(json.dumps(report_to_dict(found)), encoding="utf-8")
        back = read_modes(path)
        assert np.array_equal(back.poles, found.modes.poles)
        assert back.covariance is not None
        assert found.modes.covariance is not None
        assert np.array_equal(back.covariance, found.modes.covariance)

    def test_the_page_and_the_json_say_the_same(self, found: Identification, springs: Reconstruction) -> None:
        content = report_to_dict(content_of(found, reconstruction=springs))
        text = Page(report(content_of(found, reconstruction=springs))).text
        verdict = content["verdict"]
        assert isinstance(verdict, dict)
        for said in (verdict["headline"]["text"].capitalize(), *(check["text"] for check in verdict["checks"])):
            assert said in text


class TestScriptsFromRightToLeft:
    """Names in them are isolated: browsers would draw a number behind such a name before it."""

    NAME = "قناة التسارع"

    def test_in_sentences(self) -> None:
        assert str(sentence_html(f"{self.NAME} (5 %) of seat")) == f"<bdi>{self.NAME}</bdi> (5 %) of seat"

    def test_above_pictures(self) -> None:
        t = np.arange(0, 3, 0.01)
        decay = np.exp(-t) * np.cos(30 * t) + 1e-3 * np.random.default_rng(1).standard_normal(t.size)
        page = report(identify(suspid.as_record(decay, fs=100.0, channels=[self.NAME])))
        assert re.search(rf"<h3><bdi>{self.NAME}</bdi>: [\d.]+ % explained</h3>", page)
