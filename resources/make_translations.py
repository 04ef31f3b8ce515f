#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Brings the add-on's translations (resources/translations/*.ts) up to date with its texts and
compiles them (needs lrelease of Debian's package qttools5-dev-tools):

    /usr/bin/python3 resources/make_translations.py [--check]

Translations that exist are kept; texts without one are named. --check only compares.
"""

import ast
import glob
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PACKAGE = os.path.join(ROOT, "freecad_workbench", "freecad", "tsolid")
FOLDER = os.path.join(PACKAGE, "resources", "translations")
CONTEXT = "tsolid"  # of tr() in runner.py


def literal(node):
    """The text of a string constant; None for anything else."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


def texts_of_python(path):
    with open(path, encoding="utf-8") as stream:
        tree = ast.parse(stream.read())
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        words = [literal(a) for a in node.args]
        if name == "tr" and len(words) == 1 and words[0]:
            yield CONTEXT, words[0]
        elif name in ("QT_TRANSLATE_NOOP", "translate") and len(words) == 2 and all(words):
            yield tuple(words)


def texts_of_form(path):
    root = ET.parse(path).getroot()
    for node in root.iter("string"):
        yield root.findtext("class"), node.text.strip()


def all_texts():
    """{context: [text]}, sorted."""
    found = {}
    for path in glob.glob(os.path.join(PACKAGE, "*.py")):
        for context, text in texts_of_python(path):
            found.setdefault(context, set()).add(text)
    for path in glob.glob(os.path.join(PACKAGE, "resources", "*.ui")):
        for context, text in texts_of_form(path):
            found.setdefault(context, set()).add(text)
    return {context: sorted(found[context]) for context in sorted(found)}


def translations(path):
    """{(context, text): translation} of a .ts file."""
    if not os.path.exists(path):
        return {}
    return {
        (context.findtext("name"), message.findtext("source")): message.findtext("translation")
        for context in ET.parse(path).getroot().iter("context")
        for message in context.iter("message")
        if message.findtext("translation")
    }


def ts_text(language, texts, known):
    root = ET.Element("TS", version="2.1", language=language, sourcelanguage="en")
    for context, sources in texts.items():
        node = ET.SubElement(root, "context")
        ET.SubElement(node, "name").text = context
        for source in sources:
            message = ET.SubElement(node, "message")
            ET.SubElement(message, "source").text = source
            translation = ET.SubElement(message, "translation")
            translation.text = known.get((context, source))
            if translation.text is None:
                translation.set("type", "unfinished")
    ET.indent(root, " ")
    head = '<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE TS>\n'
    return head + ET.tostring(root, encoding="unicode") + "\n"


def main(arguments):
    check = arguments == ["--check"]
    texts = all_texts()
    missing = 0
    for path in sorted(glob.glob(os.path.join(FOLDER, "*.ts"))):
        language = os.path.splitext(path)[0].rsplit("_", 1)[1]
        known = translations(path)
        for context, sources in texts.items():
            for source in sources:
                if (context, source) not in known:
                    print("%s: no translation of %r (%s)" % (language, source, context))
                    missing += 1
        fresh = ts_text(language, texts, known)
        with open(path, encoding="utf-8") as stream:
            same = stream.read() == fresh
        if check:
            if not same:
                print("%s is not up to date" % path)
                missing += 1
            continue
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(fresh)
        lrelease = shutil.which("lrelease", path=os.environ["PATH"] + ":/usr/lib/qt5/bin")
        compiled = os.path.splitext(path)[0] + ".qm"
        subprocess.run([lrelease, "-silent", path, "-qm", compiled], check=True)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
