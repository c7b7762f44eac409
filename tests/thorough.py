"""Further cases of checks that ``make test`` runs on fewer of them, so that it stays short; ``make bench`` runs all.

A check over random arrays (a parameter ``seed`` or ``block``) keeps its first ones, and the longest checks of many
cases, named in :data:`EVERY`, keep every second, third, ... of them, see :mod:`tests.conftest`.  Others name what they
keep with :func:`keep`, or mark a whole test with :data:`thorough` where a smaller test of the same claim stands beside
it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import pytest

SEEDED = {"seed": 3, "block": 1}  # parameters of random arrays, and how many of each check are kept

# The longest checks of many cases, and which of them are kept: the first of every two, or of every three.
EVERY = {
    "analysis/measurements/test_study_orders.py::test_a_step_across_a_switch_errs_by_the_tolerance": 2,
    "analysis/test_body_map.py::test_rates_by_cells_are_those_of_the_words_of_the_rule": 2,
    "analysis/test_cell_path.py::test_wheels_enter_and_leave_as_in_small_steps": 2,
    "analysis/test_continuum.py::test_damped_motion_ends_at_a_stable_heading": 2,
    "analysis/test_dynamics_mujoco.py::test_engines_path_is_that_of_full_dynamics": 2,
    "analysis/test_equilibria.py::test_judged_verdicts_equal_a_check_at_the_point": 2,
    "analysis/test_filippov.py::test_dense_samples_along_edges_reach_the_exact_slope": 2,
    "analysis/test_load_regions.py::test_a_line_of_wheels_that_takes_the_whole_load_is_crossed": 3,
    "analysis/test_load_regions.py::test_loads_beside_such_a_line_are_those_of_floats": 2,
    "analysis/test_minimizers.py::test_interior_on_rings_grids_and_random_arrays": 3,
    "analysis/test_minimizers.py::test_unique_twists_agree": 3,
    "analysis/test_minimizers.py::test_values_agree": 3,
    "analysis/test_nearest.py::test_each_cell_follows_the_literal_rule": 3,
    "analysis/test_nearest.py::test_pruning_keeps_wheels_closer_together_than_doubles_resolve": 2,
    "analysis/test_nearest.py::test_pruning_keeps_wheels_in_units_below_the_floats": 2,
    "analysis/test_proved_minima.py::test_no_sampled_rate_is_beyond_what_a_body_can_do": 2,
    "analysis/test_regimes.py::test_twists_are_those_of_the_interior_point_method": 2,
    "analysis/test_roller.py::test_a_path_slides_home_where_the_twist_jumps": 2,
    "analysis/test_stiffness.py::test_feedback_of_high_gain_is_that_of_gain_one_in_its_own_time": 2,
    "proofs/answers/test_answers.py::test_every_answer_has_a_sentence_and_the_same_keys": 3,
    "proofs/answers/test_answers.py::test_the_distance_halves_as_fast_as_said": 2,
    "proofs/answers/test_destinations.py::test_auto_refuses_in_one_line": 2,
    "proofs/headings/test_equilibrium_headings.py::test_a_grid_of_headings_finds_what_is_listed_and_no_more": 2,
    "proofs/measurements/test_stress.py::test_a_built_in_scene_holds": 2,
    "proofs/robust/test_certified_bound.py::test_irrational_places_are_followed": 2,
    "proofs/robust/test_robust_feedback.py::test_no_array_of_the_box_is_slower": 2,
    "proofs/robust/test_smooth_bounds.py::test_every_array_has_its_equilibrium_in_the_disc_and_it_attracts": 2,
    "proofs/test_audit_lyapunov.py::test_agrees_with_the_translation_clause": 3,
    "proofs/test_audit_lyapunov.py::test_invalid_on_arrays_with_a_witness": 3,
    "proofs/test_audit_lyapunov.py::test_random_arrays_against_sampled_rates": 2,
    "proofs/test_cascade_law.py::test_full_turns_that_contract_bring_the_body_home": 2,
    "proofs/test_certificate.py::test_each_built_in_scene_has_a_valid_certificate": 3,
    "proofs/test_certificates_against_paths.py::test_accepted_certificates_of_tied_arrays_agree_with_paths": 2,
    "proofs/test_certified_region.py::test_the_region_lies_in_the_square_and_on_its_border_w_is_not_below": 2,
    "proofs/test_certified_region.py::test_w_falls_everywhere_in_the_region": 2,
    "proofs/test_checker.py::test_another_verdict_is_rejected": 2,
    "proofs/test_checker.py::test_the_evidence_of_the_feedback_clause_is_load_bearing": 3,
    "proofs/test_contact_rules.py::test_evidence_verifies": 3,
    "proofs/test_control_lyapunov.py::test_where_squares_fail_a_p_is_found_or_excluded": 2,
    "proofs/test_driven_feedback.py::test_under_box_the_law_imposes_its_motion_within_the_reach": 3,
    "proofs/test_driven_feedback.py::test_under_ellipse_forces_and_separators_exclude_each_other": 2,
    "proofs/test_driven_feedback.py::test_under_ellipse_the_speeds_impose_their_twist_at_the_equilibrium": 3,
    "proofs/test_every_load.py::test_any_load": 2,
    "proofs/test_every_load.py::test_the_witness_fails_as_a_known_load": 2,
    "proofs/test_friction_axis_verdicts.py::test_certificates_name_the_axes_and_the_checker_follows_them": 2,
    "proofs/test_friction_axis_verdicts.py::test_the_evidence_of_every_clause_verifies": 2,
    "proofs/test_friction_axis_verdicts.py::test_the_scenes_give_what_an_engineer_expects": 3,
    "proofs/test_input_margin.py::test_within_the_margin_all_cells_in_reach_have_a_common_input": 2,
    "proofs/test_invariance.py::test_an_energy_is_found": 3,
    "proofs/test_inward_slope.py::test_no_disc_is_claimed_where_the_distance_may_grow": 3,
    "proofs/test_inward_slope.py::test_the_distance_falls_all_over_the_disc": 3,
    "proofs/test_leading_terms.py::test_random_systems_against_formulas": 2,
    "proofs/test_leading_terms.py::test_random_systems_against_paths": 2,
    "proofs/test_plain_ties.py::test_equilibria_of_tied_systems": 2,
    "proofs/test_plain_ties.py::test_verdicts_on_tied_systems": 2,
    "proofs/test_roller.py::test_speeds_impose_their_twists": 3,
    "proofs/test_system_checker.py::test_random_relays_that_a_v_decides_are_certified": 2,
    "proofs/test_systems.py::test_asymptotically_stable_systems_contract": 2,
    "proofs/test_systems.py::test_lyapunov_functions_never_contradict_the_complete_fan": 2,
    "proofs/test_theorem4.py::test_pruning_changes_nothing_for_built_in_scenes": 3,
    "proofs/test_theorem4.py::test_pruning_changes_nothing_for_random_arrays": 2,
    "proofs/test_theorem4.py::test_the_theorem_holds_for_inward_rings": 3,
    "proofs/test_tied_arrays.py::test_verdicts_of_tied_arrays_agree_with_paths": 2,
    "proofs/test_tied_box.py::test_verdicts_at_corners_of_cells_agree_with_paths": 2,
    "proofs/test_translation.py::test_the_region_ends_where_the_literal_rule_first_fails": 2,
    "proofs/test_written_verdicts.py::test_known_systems": 3,
    "rehearsals/test_mirror.py::test_a_new_clause_is_shown_everywhere": 2,
    "reports/interface/test_results.py::test_results_print_in_few_lines": 2,
    "reports/sweeps/test_sweep.py::test_a_grid_answers_as_checks_one_by_one": 2,
    "reports/sweeps/test_sweep.py::test_a_wheel_of_a_layout_varies_on_its_own": 2,
    "reports/test_bodies.py::test_a_path_of_every_kind_through_the_command": 2,
    "reports/test_certified_law.py::test_away_from_the_worlds_origin_the_body_comes_home_too": 2,
    "reports/test_certified_law.py::test_small_starts_come_home_under_the_certified_law": 2,
    "reports/test_certified_law.py::test_small_starts_come_home_under_the_other_rules": 3,
    "reports/test_certified_law.py::test_terminal_json_and_report_name_the_same_law": 2,
    "reports/test_certified_law.py::test_the_first_steps_are_those_of_the_certified_law": 2,
    "reports/test_cli.py::test_bad_input_through_the_real_program": 2,
    "reports/test_cli.py::test_partition_picture_is_whole_and_reproducible": 2,
    "reports/test_cli.py::test_pruning_changes_no_verdict": 2,
    "reports/test_cli_continuum.py::test_the_derivation_has_a_section": 3,
    "reports/test_cli_maps.py::test_pictures_are_whole_and_equal_for_equal_input": 2,
    "reports/test_cli_system_paths.py::test_pictures": 2,
    "reports/test_derivation.py::test_equal_input_gives_equal_reports": 3,
    "reports/test_derivation.py::test_every_step_has_a_section": 3,
    "reports/test_derivation.py::test_other_rules_are_reported_in_all_formats": 3,
    "reports/test_driven_loop.py::test_small_steps_with_a_minimizer_lead_the_same_way": 2,
    "reports/test_feedback_views.py::test_rates_and_reaches_on_the_terminal_are_true": 2,
    "reports/test_feedback_views.py::test_the_report_states_the_law": 2,
    "reports/test_field_map.py::test_pictures_records_and_views": 2,
    "reports/test_field_map.py::test_rows_are_minimizers_of_the_dissipation": 2,
    "reports/test_film_browser.py::test_a_page_opens_quietly_and_fits": 2,
    "reports/test_frames.py::test_slips_are_those_of_the_twist": 2,
    "reports/test_html.py::test_the_page_stands_alone": 2,
    "reports/test_html_browser.py::test_a_report_opens_quietly_and_fits": 2,
    "reports/test_late_loops.py::test_paths_end_within_the_bound": 2,
    "reports/test_latex_compiles.py::test_every_built_in_scene_compiles_and_fits": 3,
    "reports/test_limited_speeds.py::test_limits_are_kept_and_v_falls_as_certified": 3,
    "reports/test_limited_speeds.py::test_orbits_are_those_without_limits": 2,
    "reports/test_limited_speeds.py::test_paths_against_brute_force": 2,
    "reports/test_measured_arrays.py::test_a_check_of_a_measured_array_ends_soon": 3,
    "reports/test_not_certified.py::test_no_view_shows_a_number_that_is_none": 3,
    "reports/test_precision.py::test_figures_are_written": 2,
    "reports/test_steps.py::test_commands_name_their_steps_on_a_terminal_only": 3,
    "reports/test_unit_of_length.py::test_certificates_are_about_the_scene_whatever_its_length": 2,
    "reports/test_unit_of_length.py::test_closed_loops_are_the_same_paths": 3,
    "reports/test_unit_of_length.py::test_every_result_is_verified_and_one_for_another_length_is_refused": 3,
    "reports/test_unit_of_length.py::test_rings_with_irrational_and_measured_places": 3,
    "reports/test_unit_of_length.py::test_the_certified_region_is_the_same": 2,
    "reports/test_unit_of_length.py::test_verdicts_answers_and_rates_are_the_same": 3,
    "reports/test_unknown_loads.py::test_json_says_which_loads_are_meant": 3,
    "reports/test_unknown_loads.py::test_reports_show_the_load_that_refutes_and_say_what_is_about_one_load": 2,
    "reports/test_unknown_loads.py::test_what_needs_one_load_is_refused_in_one_line": 3,
    "reports/test_vehicle_command.py::test_files_are_reproducible": 2,
}

thorough = pytest.mark.thorough


def keep(kept: int, cases: Iterable[Any]) -> list[Any]:
    """The cases of a parameter, those after the first ones marked as thorough.

    Args:
        kept: how many are not marked.
        cases: values, or tuples of values for several parameters.
    """
    listed = list(cases)
    further = [pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=thorough) for case in listed[kept:]]
    return [*listed[:kept], *further]


def mark_further(items: Iterable[pytest.Item]) -> None:
    """Mark further random arrays, and of the checks in :data:`EVERY` the cases between those that are kept."""
    cases: Counter[str] = Counter()
    for item in items:
        if item.get_closest_marker("thorough") is not None:
            continue
        if is_further(item):
            item.add_marker(thorough)
            continue
        check = check_of(item)
        if cases[check] % EVERY.get(check, 1):
            item.add_marker(thorough)
        cases[check] += 1


def check_of(item: pytest.Item) -> str:
    """The name of a test without its case, as :data:`EVERY` spells it."""
    return item.nodeid.partition("[")[0].removeprefix("tests/")


def is_further(item: pytest.Item) -> bool:
    """Whether a test is about a random array beyond the first ones of its check."""
    callspec = getattr(item, "callspec", None)
    indices = {} if callspec is None else callspec.indices
    return any(indices.get(name, 0) >= kept for name, kept in SEEDED.items())
