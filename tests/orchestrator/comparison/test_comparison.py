"""From the tables of a sweep to claims, figures and the page."""

from __future__ import annotations

import re
from pathlib import Path

import polars as pl
import pytest
from PIL import Image

from orchestrator.comparison import published
from orchestrator.comparison.charts import charts
from orchestrator.comparison.claims import findings, judgeable
from orchestrator.comparison.data import behaviour, load
from orchestrator.comparison.page import render, summary_table, write_comparison
from orchestrator.errors import InputError


def test_rates_are_over_all_episodes_of_a_controller(sweep) -> None:
    comparison = load(sweep())
    assert comparison.time("dwa") == 8 * 100.0
    assert comparison.collision_rate("dwa") == pytest.approx(60 / 800)
    energy = comparison.energies("dwa").sum()
    assert comparison.collision_energy_rate("dwa") == pytest.approx(energy / 800)
    assert comparison.low.collision_rate("dwa") == 0.0
    assert comparison.high.collision_rate("dwa") == pytest.approx(60 / 400)


def test_parquet_tables_say_the_same(sweep) -> None:
    of_csv = load(sweep())
    for file in sweep().glob("*.csv"):
        file.unlink()
    of_parquet = load(sweep(form="parquet"))
    assert findings(of_parquet) == findings(of_csv)
    assert summary_table(of_parquet).equals(summary_table(of_csv))


def test_pairs_are_of_the_same_scenarios_and_leave_out_what_has_no_value(sweep) -> None:
    comparison = load(sweep(lost=("True_1d+_350",)))
    first, second = comparison.pairs("baseline", "dwa", "path_length_ratio")
    assert len(first) == len(second) == 7
    assert comparison.arrival_rate("dwa") == pytest.approx(7 / 8)


def test_every_claim_is_judged_by_the_numbers(sweep) -> None:
    found = {finding.text: finding for finding in findings(load(sweep()))}
    assert found["L/Lcr: Baseline > RVO > DWA over all densities"].holds
    assert found["J/Jcr: DWA varies its speed least, relative to the robot alone, over all densities"].holds
    assert not found["the same in absolute terms, J [m/s], over all densities"].holds  # all alike
    assert found["T/Tcr: Baseline is the fastest at low density"].holds
    assert found["Colliding: RVO > DWA over all densities"].holds
    assert found["DWA has the most collisions in total"].holds
    # 40 / 400 s, 60 / 800 s, 20 / 640 s
    assert found["f_c [1/s]: Baseline > DWA > RVO over all episodes, worst first"].numbers == (
        "Baseline 0.100, DWA 0.075, RVO 0.031"
    )
    assert {finding.number for finding in found.values()} == set(range(1, 8))


def test_claims_need_the_papers_controllers_and_densities(sweep) -> None:
    folder = sweep()
    table = pl.read_csv(folder / "results.csv")
    table.filter(pl.col("controller") != "rvo").write_csv(folder / "results.csv")
    assert not judgeable(load(folder))
    table.filter(pl.col("people") == 50).write_csv(folder / "results.csv")
    assert not judgeable(load(folder))


def test_the_page_needs_no_network_and_has_arrivals_beside_safety_and_figures_for_print(sweep) -> None:
    folder = sweep(lost=("True_1d+_350",))
    files = write_comparison(folder)
    page = files["report"].read_text()
    assert not re.search(r'(?:src|href)="(?:https?:)?//', page)
    assert not re.search(r"url\((?!#)", page)
    assert "@import" not in page
    for title in ("At a glance", "Collisions"):
        section = page.partition(f"<h2>{title}</h2>")[2].partition("</table>")[0]
        assert "arrived" in section and "88 %" in section
    for number in (*published.COLLISION_RATE.values(), *published.COLLISION_ENERGY_RATE.values()):
        assert f"{number:.3f}" in page
    assert pl.read_csv(files["claims"])["holds"].dtype == pl.Boolean
    names = {path.stem for path in (folder / "figures").glob("*.png")}
    assert names == {"radar", "energy", "heat_colliding", "heat_time_ratio", "intervals", "paths"}
    for name in names:
        with Image.open(folder / "figures" / f"{name}.png") as image:
            assert min(image.size) > 300
        assert (folder / "figures" / f"{name}.pdf").read_bytes().startswith(b"%PDF")


def test_the_summary_has_the_papers_deviations_beside_ours(sweep) -> None:
    table = summary_table(load(sweep()))
    row = table.filter(
        (pl.col("density") == "low") & (pl.col("metric") == "colliding") & (pl.col("controller") == "dwa")
    ).to_dicts()[0]
    assert (row["episodes"], row["mean"], row["standard_deviation"]) == (4, 1.0, 0.0)
    assert row["paper_standard_deviation"] == 0.04


def test_a_suite_that_is_not_the_papers_has_a_line_per_scenario(sweep) -> None:
    folder = sweep()
    table = pl.read_csv(folder / "results.csv").with_columns(pl.lit("1d+").alias("flow"))
    table.write_csv(folder / "results.csv")
    page = render(load(folder))
    assert "Scenario by scenario" in page
    assert "What the paper claims" not in page
    assert "<td>False_2dx_350</td>" in page
    assert "Where it is hard" not in page


def test_a_sweep_without_a_collision_has_a_page_too(sweep) -> None:
    folder = sweep()
    (folder / "collisions.csv").unlink()
    comparison = load(folder)
    assert [chart.name for chart in charts(comparison)] == [
        "radar",
        "heat_colliding",
        "heat_time_ratio",
        "intervals",
        "paths",
    ]
    assert comparison.collision_rate("dwa") == 0.0


def test_what_is_no_sweep_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no results"):
        load(tmp_path)
    (tmp_path / "results.csv").write_text("a,b\n1,2\n")
    with pytest.raises(InputError, match="have no column 'time'"):
        load(tmp_path)


def test_behaviours_are_named_as_in_the_paper() -> None:
    assert behaviour("orca", 0.5, False) == "RVO 0.5 s, not reactive"
    assert behaviour("social_force", None, True) == "social forces, reactive"
