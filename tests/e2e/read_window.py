"""Prints the widgets of a process's window as a screen reader finds them (AT-SPI), as JSON. A process of its own, because the
library does not forget an application that has ended."""
import json
import sys

import pyatspi


def described(widget):
    described = {"role": widget.getRoleName(), "name": widget.name,
                 "showing": widget.getState().contains(pyatspi.STATE_SHOWING)}
    try:
        box = widget.queryComponent().getExtents(pyatspi.DESKTOP_COORDS)
        described["box"] = [box.x, box.y, box.width, box.height]
    except NotImplementedError:
        pass
    try:
        value = widget.queryValue()
        described["value"], described["max"] = value.currentValue, value.maximumValue
    except NotImplementedError:
        pass
    return described


def walk(widget, depth=0):
    yield {**described(widget), "depth": depth}
    for child in widget:
        if child is not None:
            yield from walk(child, depth + 1)


process = int(sys.argv[1])
applications = [each for each in pyatspi.Registry.getDesktop(0) if each is not None]
print(json.dumps([widget for each in applications if each.get_process_id() == process for widget in walk(each)]))
