"""The page of the workbench in Chromium: every control does what it says."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Route, expect

import nonsmooth as ns
from tests.browser import needs_chromium
from tests.reports.conftest import Invoke
from tests.reports.workbench.workbench_page import (
    Opened,
    document,
    drag,
    edited,
    proved,
    settled,
)
from tests.workbench_server import Workbench

pytestmark = needs_chromium

FIRST_WHEEL = "drawing.view.at(drawing.wheels()[0].x, drawing.wheels()[0].y)"
FIRST_RIM = """(() => { const knob = drawing.element.querySelector('[data-rim="0"]');
    const [x, y] = drawing.view.at(drawing.wheels()[0].x, drawing.wheels()[0].y);
    const { unit } = drawing.view;
    return [x + unit * knob.getAttribute('cx'), y + unit * knob.getAttribute('cy')]; })()"""
FIRST_START = "drawing.view.at(...workbench.store.now.starts[0])"
MIDDLE = "[drawing.view.width / 2, 12]"


def test_the_page_asks_its_own_server_only_and_hides_the_token(opened: Opened, server: Workbench) -> None:
    own = f"http://127.0.0.1:{server.port}/"
    assert all(address.startswith(own) for address in opened.asked if not address.startswith("blob:"))
    assert "token" not in opened.page.url
    assert [address for address in opened.asked if server.token in address] == [server.address]


def test_the_answers_are_words_with_forms(page: Page) -> None:
    cards = page.locator("#answers .answer")
    words = [card.locator(".answer-word").inner_text() for card in cards.all()]
    assert words == ["comes home", "drifts", "can be held"]
    icons = [card.locator("use").get_attribute("href") for card in cards.all()]
    assert icons == ["#i-good", "#i-fair", "#i-good"]
    expect(page.locator("#live")).to_have_text("Position: comes home. Heading: drifts. Pose: can be held.")


def test_a_wheel_is_dragged_in_one_step_of_undo(page: Page) -> None:
    after = edited(page, lambda: drag(page, FIRST_WHEEL, (40, 25)))
    x, y = after["wheel"][0]["position"]
    assert x > 1 > y
    assert after["wheel"][1:] == document(page)["wheel"][1:]
    settled(page)
    shown = page.evaluate("() => { const w = workbench.results.geometry.wheels[0]; return [w.x, w.y]; }")
    assert shown == pytest.approx([x, y])
    edited(page, lambda: page.click("#undo"))
    assert document(page)["wheel"][0]["position"] == [1, 1]
    edited(page, lambda: page.click("#redo"))
    assert document(page)["wheel"][0]["position"] == [x, y]


def test_a_rim_is_turned_by_its_handle(page: Page) -> None:
    page.keyboard.press("n")
    page.evaluate("() => new Promise(requestAnimationFrame)")
    heading = edited(page, lambda: drag(page, FIRST_RIM, (40, -20)))["wheel"][0]["heading"]
    assert isinstance(heading, list)
    settled(page)
    page.keyboard.down("Shift")
    straight = edited(page, lambda: drag(page, FIRST_RIM, (0, 60)))["wheel"][0]["heading"]
    page.keyboard.up("Shift")
    assert straight.endswith(" deg")
    assert int(straight.split()[0]) % 15 == 0


def test_fields_take_exact_formulas_and_show_their_errors(page: Page) -> None:
    page.locator("[data-row='1'] button").click()
    field = page.locator("#wheel-fields").get_by_label("x", exact=True)
    field.fill("-sqrt(3)/2")
    assert edited(page, lambda: field.press("Enter"))["wheel"][1]["position"] == ["-sqrt(3)/2", 1]
    field.fill("sqrt(")
    edited(page, lambda: field.press("Enter"))
    page.locator("#wheel-fields .field-error:visible").wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    assert "wheel" in page.locator("#error").inner_text()
    page.locator("#drawing").focus()
    edited(page, lambda: page.keyboard.press("Control+z"))
    settled(page)
    assert field.get_attribute("aria-invalid") == "false"
    assert not page.locator("#error").is_visible()


def test_every_button_for_wheels_does_what_it_says(page: Page) -> None:
    before = document(page)["wheel"]

    def press(name: str) -> list[dict[str, object]]:
        found: list[dict[str, object]] = edited(page, lambda: page.click(f"[data-action={name}]"))["wheel"]
        return found

    def undo() -> None:
        edited(page, lambda: page.keyboard.press("Control+z"))
        assert document(page)["wheel"] == before
        settled(page)  # what comes above a row moves it: no click may begin on one and end on another

    assert len(press("add")) == 5
    undo()
    page.locator("[data-row='0'] button").click()
    assert len(press("copy")) == 5
    undo()
    page.locator("[data-row='0'] button").click()
    assert press("delete") == before[1:]
    undo()
    page.keyboard.press("Escape")  # none selected: all are meant
    assert press("mirror-x")[0]["position"] == [-1, 1]
    undo()
    assert press("mirror-y")[0]["position"] == [1, -1]
    undo()
    page.locator("[data-row='0'] button").click()
    assert press("rotate-left")[0]["position"] != [1, 1]
    assert press("rotate-right")[0]["position"] == [1, 1]
    edited(page, lambda: page.click("#undo"))
    undo()
    edited(page, lambda: drag(page, FIRST_WHEEL, (17, 13)))
    page.select_option("#snap", "0.5")
    assert press("snap")[0]["position"] == [1, 1]
    page.select_option("#snap", "0")


def test_a_grid_holds_dragged_wheels(page: Page) -> None:
    page.select_option("#snap", "0.25")
    x, y = edited(page, lambda: drag(page, FIRST_WHEEL, (61, 47)))["wheel"][0]["position"]
    page.select_option("#snap", "0")
    assert (4 * x).is_integer() if isinstance(x, float) else True
    assert [x, y] != [1, 1]


def test_the_sliders_change_what_they_name(page: Page) -> None:
    for name, path in {
        "mu_side-mu_roll": ["friction", "mu_side"],
        "checked-radius": ["check", "radius"],
        "characteristic-length": ["check", "length"],
    }.items():
        slider = page.locator(f"#slider-{name}")
        before = document(page)[path[0]][path[1]]
        slider.focus()
        after = edited(page, lambda: page.keyboard.press("ArrowLeft"))[path[0]][path[1]]
        assert after != before
        settled(page)
        assert slider.get_attribute("aria-valuetext") == page.locator(f"output[for=slider-{name}]").inner_text()


def test_wheels_of_one_kind_and_of_one_speed_have_one_slider(page: Page) -> None:
    """Wheels that differ have their own; each moves all of its wheels, and no other."""
    wheels = edited(page, lambda: page.evaluate(SECOND_KIND))["wheel"]
    settled(page)
    labels = page.locator("#sliders label").all_inner_texts()
    assert labels[:2] == ["mu_side / mu_roll, wheels 1, 3\u20134", "mu_side / mu_roll, wheel 2"]
    assert labels[2:4] == ["Speed, wheels 1, 3\u20134", "Speed, wheel 2"]
    sliders = page.locator("#sliders input")
    sliders.nth(1).focus()
    after = edited(page, lambda: page.keyboard.press("ArrowRight"))["wheel"]
    assert after[1]["mu_side"] == pytest.approx(wheels[1]["mu_side"] + 0.01)
    assert [after[k] for k in (0, 2, 3)] == [wheels[k] for k in (0, 2, 3)]
    settled(page)
    sliders.nth(2).focus()
    faster = edited(page, lambda: page.keyboard.press("ArrowRight"))["wheel"]
    assert {faster[k]["speed"] for k in (0, 2, 3)} == {1.01}
    assert faster[1]["speed"] == 2


def test_speeds_are_set_in_the_unit_of_the_scene(page: Page) -> None:
    """Lengths in mm and speeds in m/s: what the slider says is what the document holds."""
    page.evaluate(IN_MILLIMETRES)
    settled(page)
    assert page.locator("#sliders label").all_inner_texts()[1] == "Speed [m/s]"
    slider = page.locator("#sliders input").nth(1)
    assert float(slider.input_value()) == pytest.approx(0.25)
    slider.focus()
    wheels = edited(page, lambda: page.keyboard.press("ArrowRight"))["wheel"]
    assert {wheel["speed"] for wheel in wheels} == {0.252}
    assert page.locator("label[for=slider-checked-radius]").inner_text() == "Checked radius [mm]"
    assert "Lengths are in mm, speeds in m/s." in page.locator("#wheel-hint").inner_text()
    heads = page.locator("#wheel-head th").all_inner_texts()
    assert heads == ["wheel", "x [mm]", "y [mm]", "heading [deg]", "speed [m/s]", "friction"]


@pytest.mark.usefixtures("all_stages")
def test_a_scene_with_units_has_a_card_on_inertia(page: Page) -> None:
    assert page.locator("#answers [data-key=inertia]").count() == 0
    page.evaluate(IN_MILLIMETRES.replace("check: undefined", 'check: undefined, contact: { rule: "roller" }'))
    card = page.locator("#answers [data-key=inertia]")
    card.wait_for(timeout=60_000)
    assert "a body with inertia" in card.inner_text()


def test_the_rule_that_is_shown_is_the_one_that_holds(page: Page) -> None:
    """Also where no rule is stated, but each wheel has one of its own."""
    assert page.locator("#rule").input_value() == "nearest"
    page.evaluate(OWN_RULES)
    page.wait_for_function("() => document.querySelector('#rule').value === 'mixed'")


IN_MILLIMETRES = """() => workbench.store.open({ ...workbench.store.document, units: { length: "mm", speed: "m/s" },
  check: undefined, wheel: workbench.store.document.wheel.map((wheel) =>
    ({ ...wheel, speed: 0.25, position: wheel.position.map((entry) => 100 * entry) })) })"""

OWN_RULES = """() => workbench.store.open({ ...workbench.store.document, contact: undefined,
  wheel: workbench.store.document.wheel.map((wheel, k) => ({ ...wheel, contact: k ? "ellipse" : "roller" })) })"""

SECOND_KIND = """() => { workbench.store.edit(({ document }) => ({ document: { ...document,
  wheel: document.wheel.map((wheel, k) => (k === 1 ? { ...wheel, mu_side: 0.2, mu_roll: 1, speed: 2 } : wheel)) } }));
  workbench.store.seal(); }"""


def test_small_arrows_fill_the_square(page: Page) -> None:
    assert page.locator(".layer-flow path").count() > 8
    page.evaluate("() => { workbench.drawing.hidden.add('motions'); workbench.drawing.request(); }")
    page.locator(".layer-flow path").first.wait_for(state="detached")
    page.evaluate("() => { workbench.drawing.hidden.delete('motions'); workbench.drawing.request(); }")


def test_the_page_says_where_a_path_ends_as_simulate_does(page: Page) -> None:
    edited(page, lambda: page.evaluate("() => workbench.store.edit(() => ({ starts: [[0.2, 0.4, 0.3]], until: 2 }))"))
    settled(page)
    said = page.locator("#path-ends li").first
    page.wait_for_function("() => workbench.results.paths.length === 1")
    sentence = ns.load("four-wheel").simulate((0.2, 0.4, 0.3), 2).ending[1]
    assert sentence in said.inner_text()


def test_the_keyboard_reaches_everything_of_a_wheel(page: Page) -> None:
    page.locator("#drawing").focus()
    page.keyboard.press("n")
    assert page.evaluate("() => workbench.store.selection") == [0]
    x, y = edited(page, lambda: page.keyboard.press("ArrowRight"))["wheel"][0]["position"]
    assert x > 1
    assert y == 1
    assert edited(page, lambda: page.keyboard.press("["))["wheel"][0]["heading"].endswith(" deg")
    assert len(edited(page, lambda: page.keyboard.press("c"))["wheel"]) == 5
    assert len(edited(page, lambda: page.keyboard.press("Delete"))["wheel"]) == 4
    page.keyboard.press("Control+a")
    assert page.evaluate("() => workbench.store.selection.length") == 4
    page.keyboard.press("Escape")
    assert page.evaluate("() => workbench.store.selection") == []
    page.keyboard.press("?")
    assert page.locator("#keys tr").count() == 20
    page.keyboard.press("Escape")
    assert not page.locator("#help").is_visible()
    page.click("#help-button")
    assert page.locator("#help").is_visible()
    page.click("#help-close")
    assert not page.locator("#help").is_visible()


def test_headings_of_starts_are_in_the_unit_of_the_scene_s_angles(page: Page) -> None:
    """They were in radians, beside headings of wheels in degrees."""
    edited(
        page,
        lambda: page.evaluate("""() => workbench.store.edit(({ document }) => ({
        document: { ...document, units: { length: "mm" } }, starts: [[0.2, 0.4, Math.PI / 6]] }))"""),
    )
    heading = page.get_by_label("theta of start 1")
    expect(heading).to_have_value("30")
    heading.fill("45")
    edited(page, lambda: heading.press("Enter"))
    assert page.evaluate("() => workbench.store.now.starts[0][2]") == pytest.approx(math.pi / 4)
    expect(page.get_by_text("theta [deg]")).to_be_visible()


def test_starts_are_followed_dragged_and_played(page: Page) -> None:
    edited(page, lambda: page.click("#add-start"))
    settled(page)
    assert page.locator(".layer-paths path").get_attribute("d")
    assert page.locator(".layer-events path").count() >= 1
    first = page.locator(".layer-paths path").get_attribute("d")
    edited(page, lambda: drag(page, FIRST_START, (-90, 60)))
    settled(page)
    assert page.locator(".layer-paths path").get_attribute("d") != first
    body = page.locator(".layer-bodies .moving-body")
    begins = body.get_attribute("d")
    page.click("#play")
    page.wait_for_function(
        "(begins) => document.querySelector('.layer-bodies .moving-body').getAttribute('d') !== begins", arg=begins
    )
    page.click("#play")
    assert page.locator("#clock").inner_text() != "t = 0"
    theta = page.get_by_label("theta of start 1")
    theta.fill("0.5")
    edited(page, lambda: theta.press("Enter"))
    assert page.evaluate("() => workbench.store.now.starts[0][2]") == 0.5
    edited(page, lambda: page.get_by_label("Remove start 1").click())
    assert page.locator(".layer-starts g").count() == 0


def test_the_time_of_paths_is_set_and_sought(page: Page) -> None:
    edited(page, lambda: page.click("#add-start"))
    until = page.locator("#until")
    until.fill("0.5")
    edited(page, lambda: until.press("Enter"))
    settled(page)
    assert page.evaluate("() => workbench.results.paths[0].times.at(-1)") <= 0.5
    body = page.locator(".layer-bodies .moving-body")
    begins = body.get_attribute("d")
    page.locator("#time").fill("500")
    page.evaluate("() => new Promise(requestAnimationFrame)")
    assert body.get_attribute("d") != begins
    assert page.evaluate("() => workbench.drawing.time") == pytest.approx(0.25, rel=0.01)
    until.fill("-1")
    until.press("Enter")
    assert until.get_attribute("aria-invalid") == "true"
    assert page.evaluate("() => workbench.store.now.until") == 0.5
    page.locator("#drawing").focus()
    edited(page, lambda: page.keyboard.press("Control+z"))
    page.locator("#until:not([aria-invalid])").wait_for()


@pytest.mark.usefixtures("all_stages")
def test_rules_are_chosen_and_compared(page: Page) -> None:
    rows = page.locator("#rules-body tr")
    assert [row.locator("th").inner_text() for row in rows.all()] == ["nearest", "box", "ellipse", "roller"]
    rows.nth(2).get_by_role("button").click()
    settled(page)
    assert document(page)["contact"]["rule"] == "ellipse"
    assert page.locator("#rule").input_value() == "ellipse"
    assert page.locator("#how").inner_text() == "motion: sampled in floats"
    assert page.locator(".layer-cells path").count() == 0
    assert page.locator(".layer-motions g").count() > 100
    edited(page, lambda: page.select_option("#rule", "nearest"))
    settled(page)
    assert page.locator(".layer-cells path").count() == 8


@pytest.mark.usefixtures("all_stages")
def test_clauses_and_tolerances_are_told(page: Page) -> None:
    titles = [title.inner_text().lower() for title in page.locator(".clause-title").all()]
    assert titles == ["equilibrium", "translation", "rotation", "feedback"]
    assert page.locator("#theorem .verdict").inner_text() == "holds"
    page.locator("#numbers > summary").click()
    field = page.locator("[data-path='tolerance.position'] input")
    field.fill("1/1000")
    edited(page, lambda: field.press("Enter"))
    settled(page)
    assert page.locator("#tolerance .verdict").inner_text() in {"holds", "undecided", "fails", "certified"}
    assert page.locator("#tolerance dt").count() >= 1
    page.locator("#numbers > summary").click()


def test_a_plain_system_is_a_phase_portrait(page: Page) -> None:
    page.select_option("#scene", "relay-oscillator-damped")
    page.locator("body.is-system").wait_for()
    proved(page)
    settled(page)
    assert page.locator(".layer-motions g").count() > 100
    assert page.locator(".layer-levels path.level").count() >= 3
    assert page.locator("#edits").is_hidden()
    page.keyboard.press("o")
    settled(page)
    assert len(page.evaluate("() => workbench.store.now.starts[0]")) == 2
    assert page.locator(".layer-paths path").get_attribute("d")
    edited(page, lambda: page.click("#undo"))
    edited(page, lambda: page.click("#undo"))
    assert not document(page).get("system")


def saved(page: Page, folder: Path, kind: str) -> Path:
    """What an entry of the export menu saves."""
    page.click("#export")
    with page.expect_download() as download:
        page.click(f"[data-export={kind}]")
    target = folder / f"{kind}-{download.value.suggested_filename}"
    download.value.save_as(target)
    return target


def test_files_are_opened_and_saved_byte_for_byte(opened: Opened, page: Page, tmp_path: Path) -> None:
    edited(page, lambda: drag(page, FIRST_WHEEL, (33, -21)))
    first = saved(page, tmp_path, "toml")
    assert first.name.endswith("four-wheel.toml")
    edited(page, lambda: page.click("#undo"))
    assert b'"schema"' in saved(page, tmp_path, "json").read_bytes()  # a check of the symmetric array is soon done
    edited(page, lambda: page.set_input_files("#file", first))
    settled(page)
    assert saved(page, tmp_path, "toml").read_bytes() == first.read_bytes()
    assert saved(page, tmp_path, "figure").read_bytes().lstrip().startswith(b"<?xml")
    broken = tmp_path / "broken.toml"
    broken.write_text("[[wheel]]\nposition = [1]\n", encoding="utf-8")
    page.set_input_files("#file", broken)
    page.locator("#note", has_text="broken.toml").wait_for()
    assert "required" in page.locator("#note").inner_text()
    assert [line for line in opened.said if "400 (Bad Request)" in line] == opened.said  # Chromium's own line
    opened.said.clear()


def test_the_certificate_is_accepted_by_the_checker(page: Page, tmp_path: Path, invoke: Invoke) -> None:
    page.locator("#slider-mu_side-mu_roll").focus()  # a symmetric array, whose check is soon done
    edited(page, lambda: page.keyboard.press("ArrowLeft"))
    certificate, scene = saved(page, tmp_path, "certificate"), saved(page, tmp_path, "toml")
    assert invoke("verify", str(certificate), str(scene)).status == 0
    edited(page, lambda: page.click("#undo"))
    other = saved(page, tmp_path, "toml")
    assert invoke("verify", str(certificate), str(other)).status == 1


def test_the_report_is_a_page_of_its_own(page: Page, opened: Opened, tmp_path: Path) -> None:
    page.select_option("#scene", "relay-oscillator")  # a short report
    page.locator("body.is-system").wait_for()
    settled(page)
    report = saved(page, tmp_path, "report")
    tab = opened.context.new_page()
    tab.goto(report.as_uri())
    assert "relay-oscillator" in tab.locator("main, body").first.inner_text()
    assert tab.locator("h1").inner_text()
    tab.close()


def test_a_copied_link_shows_the_same_scene(browser: Browser, page: Page, opened: Opened) -> None:
    edited(page, lambda: drag(page, FIRST_WHEEL, (21, 34)))
    edited(page, lambda: page.click("#add-start"))
    opened.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.click("#export")
    page.click("#copy-link")
    page.locator("#note", has_text="The link is copied").wait_for()
    link = page.evaluate("() => navigator.clipboard.readText()")
    other = Opened(browser, link)  # another profile: the link alone carries scene and token
    state = "() => JSON.stringify(workbench.store.now)"
    assert other.page.evaluate(state) == page.evaluate(state)
    assert "token" not in other.page.url
    assert other.said == []
    other.context.close()


@pytest.mark.usefixtures("all_stages")
def test_what_is_old_is_marked_in_the_frame_of_the_change(page: Page) -> None:
    marks = """() => new Promise((ready) => {
        const look = () => [document.getElementById('status').textContent, document.getElementById('how').textContent,
            ...['#answers', '#clauses', '#rules-section'].map((name) =>
                document.querySelector(name).classList.contains('stale'))];
        const before = look();
        workbench.store.edit(({ document }) => ({ document: { ...document, friction: { mu_roll: 1, mu_side: 0.3 } } }));
        requestAnimationFrame(() => ready([before, look()])); })"""
    held: list[Route] = []

    def hold(route: Route) -> None:  # no answer comes before the frame
        held.append(route)

    page.route("**/api/view", hold)
    before, after = page.evaluate(marks)
    assert before == ["exact", "cells: exact", False, False, False]
    assert after == ["checking …", "cells follow …", True, True, True]
    for route in held:
        route.continue_()
    page.unroute("**/api/view")
    settled(page)
    assert page.locator("#status").inner_text() == "exact"
    assert page.locator(".stale").count() == 0


def test_an_array_without_cells_says_why_and_shows_the_rest(page: Page) -> None:
    line = "no cells and no answers: required cells of rule box within 12 s, received an array that takes longer"
    first = page.evaluate("() => { const { cells, edges, rule, ...rest } = workbench.results.geometry; return rest; }")
    first["values"]["rule"] = "box"
    others = [{"rule": "nearest", "answers": [{"key": "position", "answer": "leaves", "tone": "bad", "sentence": ""}]}]
    stages = [
        {**first, "stage": "fast", "geometry": "later", "note": "the cells take a moment", "cells": [], "edges": []},
        {
            **first,
            "stage": "fast",
            "geometry": "none",
            "note": "no cells: they take too long",
            "cells": [],
            "edges": [],
        },
        {"stage": "unanswered", "message": line, "key": None},
        {"stage": "comparison", "rules": others},
        {"stage": "done"},
    ]
    text = "".join(f"{json.dumps(stage)}\n" for stage in stages)
    page.route("**/api/view", lambda route: route.fulfill(body=text, content_type="application/x-ndjson"))
    edited(page, lambda: page.select_option("#rule", "box"))
    expect(page.locator("#error")).to_have_text(line)
    expect(page.locator("#status")).to_have_text("not checked: see the message")
    expect(page.locator(".answer-word")).to_have_text(["…"] * 3)
    expect(page.locator(".layer-cells path")).to_have_count(0)
    expect(page.locator(".layer-wheels .wheel")).to_have_count(4)
    expect(page.locator("#how")).to_have_text("no cells: they take too long")
    rows = [re.compile(r"box\s*not checked"), re.compile(r"nearest\s*leaves")]
    expect(page.locator("#rules-body tr")).to_have_text(rows)


def test_layers_are_hidden_and_the_view_is_moved(page: Page) -> None:
    page.click("#layers-button")
    page.click("[data-layer=cells]")
    expect(page.locator(".layer-cells path")).to_have_count(0)
    page.click("[data-layer=cells]")
    page.keyboard.press("Escape")
    scale = "() => workbench.drawing.view.scale"
    page.click("#fit")
    before = page.evaluate(scale)
    page.click("#zoom-in")
    assert page.evaluate(scale) > before
    page.click("#zoom-out")
    page.mouse.move(*[700, 300])
    middle = page.evaluate("() => workbench.drawing.view.x")
    drag(page, MIDDLE, (50, 0))
    assert page.evaluate("() => workbench.drawing.view.x") < middle
    page.click("#fit")
    assert page.evaluate(scale) == pytest.approx(before)
