"""Does every way in which a program can fail end in a status and one sentence?"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from programs import GRAY, TIP, program, saying

from simtip import detect
from simtip.errors import InputError

posix = pytest.mark.skipif(os.name != "posix", reason="signals")


def seen(reference, **settings):
    return detect.configure(reference, settings)(GRAY)


def test_a_tip_arrives_with_all_that_is_known_of_it(tmp_path):
    said = (
        '{"tip_px": [3.25, 4], "axis": [0, -2], "covariance_px": [[2, 1], [1, 2]],'
        ' "confidence": 0.5, "status": "ok", "anything": {"else": null}}'
    )
    o = seen(saying(tmp_path, said))
    assert o.ok, o.reason
    assert o.tip_px.tolist() == [3.25, 4]
    assert o.axis_px.tolist() == [0, -1]
    assert o.covariance_px.tolist() == [[2, 1], [1, 2]]
    assert o.confidence == 0.5


NO_TIP = {
    "null": ("null", "found no tip"),
    "a null tip": ('{"tip_px": null}', "found no tip"),
    "a status of its own": ('{"status": "blurred", "reason": "sd 9 px"}', "blurred: sd 9 px"),
    "a reason alone": ('{"reason": "too dark"}', "too dark"),
    "unicode": ('{"status": "\u6a21\u7cca", "reason": "\u03c3"}', "\u6a21\u7cca: \u03c3"),
    "a byte order mark": ("\ufeffnull", "found no tip"),
}


@pytest.mark.parametrize(("text", "reason"), NO_TIP.values(), ids=NO_TIP)
def test_no_tip_is_what_the_program_says_it_is(text, reason, tmp_path):
    o = seen(program(tmp_path, f"sys.stdout.buffer.write({text.encode()!r})"))
    assert o.status == "not_found"
    assert reason in o.reason


def test_a_status_that_simtip_has_is_kept(tmp_path):
    o = seen(saying(tmp_path, '{"status": "touches_border", "reason": "1 px from it"}'))
    assert (o.status, o.reason) == ("touches_border", "1 px from it")


INVALID = {
    "silence": ("", "wrote nothing"),
    "blanks": (" \n\n", "wrote nothing"),
    "words": ("the tip is at 3, 4", "no JSON"),
    "two values": (TIP + TIP, "no JSON"),
    "cut short": ('{"tip_px": [3, 4', "no JSON"),
    "nested without end": ("[" * 100_000, "no JSON"),
    "NaN": ('{"tip_px": [NaN, 4]}', "NaN is no number"),
    "infinite": ('{"tip_px": [1e999, 4]}', "not finite"),
    "a huge integer": ('{"tip_px": [1%s, 4]}' % ("0" * 400), "tip_px is"),
    "three numbers": ('{"tip_px": [3, 4, 5]}', "tip_px is"),
    "ragged": ('{"tip_px": [[3], [4, 5]]}', "tip_px is"),
    "text for numbers": ('{"tip_px": ["3", "4"]}', "tip_px is"),
    "truth for numbers": ('{"tip_px": [true, false]}', "tip_px is"),
    "a number": ("7", "it gave"),
    "no tip and no reason": ("{}", "neither tip_px"),
    "ok without a tip": ('{"status": "ok"}', "neither tip_px"),
    "ok with a null tip": ('{"status": "ok", "tip_px": null}', "neither tip_px"),
    "far off the image": ('{"tip_px": [3, 4000]}', "nowhere near the image of 20 x 12 px"),
    "an axis without length": ('{"tip_px": [3, 4], "axis": [0, 0]}', "direction"),
    "an axis of three": ('{"tip_px": [3, 4], "axis_px": [0, 1, 0]}', "axis_px is"),
    "a covariance that is none": ('{"tip_px": [3, 4], "covariance_px": [[1, 2], [2, 1]]}', "eigen"),
    "a lopsided covariance": ('{"tip_px": [3, 4], "covariance_px": [[1, 0], [1, 1]]}', "symmetric"),
    "a flat covariance": ('{"tip_px": [3, 4], "covariance_px": [1, 1]}', "covariance_px is"),
    "a boundless covariance": (
        '{"tip_px": [3, 4], "covariance_px": [[1e200, 0], [0, 1e200]]}',
        "beyond",
    ),
    "too sure": ('{"tip_px": [3, 4], "confidence": 1.5}', "between 0 and 1"),
    "sure in words": ('{"tip_px": [3, 4], "confidence": "high"}', "confidence is"),
}


@pytest.mark.parametrize(("text", "reason"), INVALID.values(), ids=INVALID)
def test_what_is_no_observation_is_said_to_be_none(text, reason, tmp_path):
    o = seen(saying(tmp_path, text))
    assert o.status == "invalid_output"
    assert reason in o.reason
    assert o.tip_px is None


def test_bytes_that_are_no_text_are_no_observation(tmp_path):
    o = seen(program(tmp_path, r"sys.stdout.buffer.write(b'\xff\x00\x1b[2J')"))
    assert o.status == "invalid_output"
    assert o.reason.isprintable()


def test_an_exit_code_is_told_with_the_end_of_what_was_said(tmp_path):
    body = r"sys.stderr.write('\x1b[2Jfirst\n' + 'x' * 100_000 + '\nno licence\n'); sys.exit(3)"
    o = seen(program(tmp_path, f"print({TIP!r})\n{body}"))
    assert o.status == "command_failed"
    assert "exit code 3" in o.reason
    assert o.reason.endswith("no licence")
    assert o.reason.isprintable()
    assert len(o.reason) < 400


@posix
@pytest.mark.parametrize("name", ["SIGSEGV", "SIGKILL", "SIGABRT"])
def test_a_signal_is_named(name, tmp_path):
    o = seen(program(tmp_path, f"os.kill(os.getpid(), signal.{name})"))
    assert o.status == "command_failed"
    assert f"signal {name}" in o.reason


NOT_STARTED = {
    "not there": ("./no-such-program", "./no-such-program cannot be started: no such file"),
    "not in PATH": ("no-such-program", "no such program in PATH; name it with its folder"),
    "a folder": ("./folder", "it is a folder"),
    "no program": ("./plain", "it may not be executed; allow it (chmod +x)"),
    "a NUL": ("./a\0b", "no such file"),
}


@posix
@pytest.mark.parametrize(("name", "said"), NOT_STARTED.values(), ids=NOT_STARTED)
def test_a_program_that_cannot_be_started_is_refused_before_any_image(
    name, said, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plain").write_text("plain")
    (tmp_path / "folder").mkdir()
    for reference, settings in ((f"{name} {{image}}", {}), ("{exe} {image}", {"exe": name})):
        with pytest.raises(InputError) as caught:
            detect.configure(f"cmd:{reference}", settings)
        assert caught.value.field == "detect.name"
        assert said in str(caught.value)
        assert "\n" not in str(caught.value)


@posix
def test_one_that_vanishes_later_is_a_failed_observation(tmp_path):
    file = tmp_path / "vanishing"
    file.write_text("#!/bin/sh\n")
    file.chmod(0o755)
    look = detect.configure(f"cmd:{file} {{image}}", {})
    file.unlink()
    o = look(GRAY)
    assert o.status == "command_failed"
    assert "vanishing cannot be started: No such file" in o.reason


def test_a_nul_in_a_value_is_no_traceback(tmp_path):
    o = seen(program(tmp_path, "", "{image} {mode}"), mode="a\0b")
    assert o.status == "command_failed"
    assert "cannot be started" in o.reason


REFUSED = {
    "nothing": ("cmd:", "no command"),
    "blanks": ("cmd:  ", "no command"),
    "no image": ("cmd:./find --json", "does not say where the image"),
    "an image only in text": ("cmd:./find {{image}}", "does not say where the image"),
    "an open quote": ("cmd:./find '{image}", "quotes"),
    "the detector's name": ("cmd:./find {image} {name}", "cannot be a parameter"),
}


@pytest.mark.parametrize(("reference", "problem"), REFUSED.values(), ids=REFUSED)
def test_a_command_that_cannot_be_is_an_input_error(reference, problem):
    with pytest.raises(InputError, match=re.escape(problem)) as caught:
        detect.get(reference)
    assert caught.value.remedy


def test_a_place_is_a_parameter_that_has_to_be_given(tmp_path):
    reference = program(tmp_path, "print(json.dumps([float(sys.argv[2]), 1]))", "{image} {gain}")
    declared = {p.name: p for p in detect.parameters_of(reference)}
    assert list(declared) == ["gain", "timeout_s", "image_format"]
    assert (declared["gain"].required, declared["gain"].type) == (True, "text")
    assert seen(reference, gain="2.5").tip_px.tolist() == [2.5, 1]
    with pytest.raises(InputError, match=r"^detect\.gain: has no value; .*--set gain="):
        detect.configure(reference)
    with pytest.raises(InputError, match="did you mean 'gain'"):
        detect.configure(reference, {"gian": "1"})
    with pytest.raises(InputError, match=r"timeout_s: .*below"):
        detect.configure(reference, {"gain": "1", "timeout_s": "0"})


def test_values_are_neither_split_nor_read_by_a_shell(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = "print(json.dumps({'reason': '|'.join(sys.argv[2:])}))"
    reference = program(tmp_path, body, "{image} --a={a} 'b c' {{a}} $HOME * {a}{a}")
    said = seen(reference, a="x; touch y  $(z)").reason
    a = "x; touch y $(z)"
    assert said == f"--a={a}|b c|{{a}}|$HOME|*|{a}{a}"
    assert not Path("y").exists()
