#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The samples of docs/robots against a running geond: robots_test.py GEOND SOURCE_FOLDER.

What runs here as it stands is run as it stands (pick.py; geond_ros2.py with stand-ins for ROS that keep what it publishes).
The programs of the controllers are run by small interpreters of the statements they use, each with its controller's own
limits: the length of strings, the number of values, what its parser takes for a number."""
import importlib.util
import math
import os
import re
import socket
import subprocess
import sys
import tempfile
import time
import types

geond, source = sys.argv[1], os.path.abspath(sys.argv[2])
samples = os.path.join(source, "docs", "robots")


def fail(sentence):
    sys.exit("FAILED: " + sentence)


def check(holds, sentence):
    if not holds:
        fail(sentence)


class Service:
    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        path = self.folder.name
        # The sample object before a camera of few pixels, which is soon computed.
        with open(path + "/sim.toml", "w") as file:
            file.write(f'scene = "{source}/config/scenes/bowling_pin.toml"\n[rangefinder]\ncolumns = 140\nrows = 140\n')
        self.process = subprocess.Popen(
            [geond, "--config", os.path.join(source, "config", "geond.toml"), "--set", "api.unix_socket=" + path + "/socket",
             "--set", "api.port=0", "--set", "http.port=-1", "--set", "robot.port=0", "--set", "store.folder=" + path + "/store",
             "--set", "station.simulation=" + path + "/sim.toml", "--set", "scan.triangles=1200", "--set", "scan.views=6", "--set", "scan.picture=false"],
            stderr=subprocess.PIPE, text=True)
        self.port = None
        for line in self.process.stderr:
            found = re.search(r"robots ask on port (\d+)", line)
            if found:
                self.port = int(found.group(1))
                break
        check(self.port, "geond did not say where robots ask")
        # What it says later must not fill the pipe.
        self.rest = subprocess.Popen(["cat"], stdin=self.process.stderr, stdout=subprocess.DEVNULL)

    def close(self):
        self.process.terminate()
        check(self.process.wait(30) == 0, "geond did not end well")
        self.rest.wait(30)


class Line:
    """The controller's end of the connection."""

    def __init__(self, port, most_in):
        self.connection = socket.create_connection(("127.0.0.1", port), timeout=60)
        self.file = self.connection.makefile("rb")
        self.most_in = most_in

    def ask(self, text):
        check(len(text.strip()) <= 80 and text.isascii(), f"'{text}' is no line for the robot port")
        self.connection.sendall(text.encode())
        answer = self.file.readline().decode("ascii")
        check(answer.endswith("\n"), "an answer without end")
        check(len(answer) - 1 <= self.most_in, f"{len(answer) - 1} characters, the controller holds {self.most_in}: {answer}")
        return answer


def text_of(name):
    with open(os.path.join(samples, name)) as file:
        return file.read()


# --- UR: URScript's statements turned into Python's; socket_read_ascii_float reads "( a , b )", at most 30 numbers.
def run_ur(port):
    line, moves = Line(port, 1023), []

    def read_ascii_float(count, name, timeout):
        answer = line.pending.pop(0)
        found = re.fullmatch(r"\(\s*(.*?)\s*\)", answer.strip())
        check(found, f"UR cannot read {answer}")
        numbers = [float(re.fullmatch(r"\s*[-+]?[0-9]+(\.[0-9]*)?\s*", word).group()) for word in found.group(1).split(",")]
        check(len(numbers) <= 30 and len(numbers) == count, f"{len(numbers)} numbers where {count} are read")
        return [count] + numbers

    line.pending = []
    python = ["def pick_part():"]
    for raw in text_of("ur.script").splitlines():
        text = raw.split("#")[0].rstrip()
        if not text or text == "def pick_part():" or text.strip() == "end":
            continue
        python.append(re.sub(r"\bp\[", "pose[", text))
    names = {
        "socket_open": lambda address, number, name: True,
        "socket_send_line": lambda text, name: line.pending.append(line.ask(text + "\n")),
        "socket_read_ascii_float": read_ascii_float,
        "socket_close": lambda name: line.connection.close(),
        "sleep": lambda seconds: time.sleep(seconds / 10),
        "pose": type("Pose", (), {"__getitem__": lambda self, numbers: list(numbers)})(),
        "get_inverse_kin": lambda place: place,
        "pose_trans": lambda a, b: a + b,
        "movej": lambda place: moves.append(("j", place)),
        "movel": lambda place, a, v: moves.append(("l", place)),
    }
    exec("\n".join(python), names)
    names["pick_part"]()
    check([kind for kind, _ in moves] == ["j", "l"], f"UR made the moves {moves}")
    return moves[1][1]


# --- ABB: a string holds 80 characters; StrToVal reads a value of the variable's own shape and no rest.
def run_abb(port):
    line = Line(port, 80)
    program = text_of("abb.mod")
    check('SocketSend geond \\Str:=question + "\\0A"' in program, "the ABB sample sends otherwise than this test reads it")
    asked = re.findall(r'Ask "([^"]+)"', program)
    check(asked == ["DIALECT ABB", "SCAN", "STATUS", "GRASP 1"], f"the ABB sample asks {asked}")

    def value(text, shape):
        check(re.fullmatch(r"[-0-9.,\[\]]+", text), f"ABB cannot read {text}")
        found = eval(text)  # brackets, commas and numbers alone
        flat = [len(part) if isinstance(part, list) else 0 for part in found]
        check(flat == shape, f"ABB reads {text} into another shape")
        return found

    line.ask(asked[0] + "\n")
    line.ask(asked[1] + "\n")
    record = [1]
    while record[0] == 1:
        time.sleep(0.05)
        record = value(line.ask(asked[2] + "\n")[:-1], [0] * 11)
    check(record[0] == 0, f"ABB is told status {record[0]}")
    position, rotation = value(line.ask(asked[3] + "\n")[:-1], [3, 4])
    check(abs(math.hypot(*rotation) - 1) < 1e-5, "ABB refuses a quaternion that is not normalised")
    return position, rotation


# --- KUKA: EKI takes the elements that kuka.xml names out of whole XML elements.
def run_kuka(port):
    import xml.etree.ElementTree as ElementTree

    line = Line(port, 4096)
    line.ask("DIALECT KUKA\n")  # in the controller by robot.dialect
    wanted = ElementTree.fromstring(text_of("kuka.xml")).findall("./RECEIVE/XML/ELEMENT")
    values, flags = {}, {}

    def ask(question):
        answer = ElementTree.fromstring(line.ask(question + "\n"))
        values.clear()
        for element in wanted:
            path = element.get("Tag").split("/")
            check(path[0] == answer.tag, f"KUKA waits for {path[0]}")
            if element.get("Set_Flag"):
                flags[element.get("Set_Flag")] = True
                continue
            place = answer if len(path) == 2 else answer.find(path[1])
            text = place.get(path[-1][1:])
            check(text is not None, f"KUKA misses {element.get('Tag')}")
            values[element.get("Tag")] = int(text) if element.get("Type") == "INT" else float(text)

    program = text_of("kuka.src")
    asked = re.findall(r'Ask\("([^"]+)"\)', program)
    check(asked == ["SCAN", "STATUS", "GRASP 1"], f"the KUKA sample asks {asked}")
    for tag in re.findall(r'EKI_Get\w+\("geond", "([^"]+)"', program):
        check(any(element.get("Tag") == tag for element in wanted), f"kuka.xml does not name {tag}")
    ask(asked[0])
    values["Geon/@Status"] = 1
    while values["Geon/@Status"] == 1:
        time.sleep(0.05)
        ask(asked[1])
    ask(asked[2])
    check(values["Geon/@Status"] == 0 and flags.get("2"), "KUKA is told no grasp")
    return [values[f"Geon/Pose/@{axis}"] for axis in "XYZABC"]


# --- FANUC: a STRING holds 254 characters; CNV_STR_REAL reads each column of 11.
def run_fanuc(port):
    line = Line(port, 254)
    program = text_of("fanuc.kl")
    asked = re.findall(r"ask\('([^']+)'\)", program)
    check(asked == ["DIALECT FANUC", "SCAN", "STATUS", "GRASP 1"], f"the FANUC sample asks {asked}")
    columns, width = map(int, re.search(r"FOR i = 1 TO (\d+) DO.*?\(i - 1\) \+ 1, (\d+)\)", program, re.S).groups())

    def ask(question):
        answer = line.ask(question + "\n")[:-1]
        check(len(answer) == columns * width, f"FANUC reads {columns} columns of {width}, not {len(answer)} characters")
        return [0.0] + [float(answer[width * i:width * (i + 1)]) for i in range(columns)]

    ask(asked[0])
    ask(asked[1])
    v = [0, 1.0]
    while v[1] == 1:
        time.sleep(0.05)
        v = ask(asked[2])
    v = ask(asked[3])
    check(v[1] == 0, f"FANUC is told status {v[1]}")
    return v[4:10]


def run_python(port):
    out = subprocess.run([sys.executable, os.path.join(samples, "pick.py"), "127.0.0.1", str(port)], capture_output=True, text=True,
                         timeout=300, check=True).stdout
    check(re.search(r"part 1 type 1 at \[", out) and re.search(r"part 2 type 4 at \[", out), f"pick.py prints {out}")
    check("grasp [" in out, f"pick.py finds no grasp: {out}")


# --- ROS 2: the node itself, with stand-ins for what it imports.
def run_ros2(port):
    published = []

    class Message(types.SimpleNamespace):
        BOX, ADD = 1, b"\x00"

        def __init__(self, **fields):
            super().__init__(header=types.SimpleNamespace(frame_id=""), **fields)

    class Node:
        def __init__(self, name):
            pass

        def declare_parameter(self, name, value):
            return types.SimpleNamespace(value=port if name == "port" else value)

        def create_publisher(self, kind, topic, depth):
            check(topic == "collision_object", f"the node publishes on {topic}")
            return types.SimpleNamespace(publish=published.append)

        def create_timer(self, seconds, callback):
            self.callback = callback

    def spin(node):
        node.callback()
        node.callback()  # the same object is not told twice

    modules = {
        "rclpy": {"init": lambda: None, "spin": spin}, "rclpy.node": {"Node": Node},
        "geometry_msgs": {}, "geometry_msgs.msg": {"Point": Message, "Pose": Message, "Quaternion": Message},
        "moveit_msgs": {}, "moveit_msgs.msg": {"CollisionObject": Message},
        "shape_msgs": {}, "shape_msgs.msg": {"SolidPrimitive": Message}}
    for name, members in modules.items():
        sys.modules[name] = types.ModuleType(name)
        vars(sys.modules[name]).update(members)
    spec = importlib.util.spec_from_file_location("geond_ros2", os.path.join(samples, "geond_ros2.py"))
    spec.loader.exec_module(importlib.util.module_from_spec(spec))
    check([message.id for message in published] == ["part_1", "part_2"], f"the node publishes {[m.id for m in published]}")
    for message in published:
        check(message.header.frame_id == "robot_base" and all(0.01 < size < 0.2 for size in message.primitives[0].dimensions),
              f"the node publishes {message}")
        q = message.primitive_poses[0].orientation
        check(abs(math.hypot(q.w, q.x, q.y, q.z) - 1) < 1e-6, "a quaternion that is not normalised")


def rotation_of_vector(v):
    angle = math.hypot(*v)
    s = math.sin(angle / 2) / angle if angle > 1e-12 else 0.5
    return [math.cos(angle / 2), s * v[0], s * v[1], s * v[2]]


def rotation_of_angles(a, b, c):
    """Rz(a) Ry(b) Rx(c), degrees."""
    (ca, sa), (cb, sb), (cc, sc) = ((math.cos(math.radians(x) / 2), math.sin(math.radians(x) / 2)) for x in (a, b, c))
    return [ca * cb * cc + sa * sb * sc, ca * cb * sc - sa * sb * cc, ca * sb * cc + sa * cb * sc, sa * cb * cc - ca * sb * sc]


def same(a, b):
    """Whether two quaternions, as precise as the dialects print them, are one turn (to 1e-6)."""
    norm = math.sqrt(sum(x * x for x in a) * sum(y * y for y in b))
    return 1 - abs(sum(x * y for x, y in zip(a, b))) / norm < 0.5e-12 / 4


service = Service()
try:
    # Each scans anew, with noise of its own: the same question to the last object must give all the same place.
    run_ur(service.port)
    run_abb(service.port)
    run_kuka(service.port)
    run_fanuc(service.port)
    run_python(service.port)
    run_ros2(service.port)
    line = Line(service.port, 4096)
    ur = None
    line.ask("DIALECT UR\n")
    ur = [float(word) for word in line.ask("GRASP 1\n").strip(" ()\n").split(",")]
    line.ask("DIALECT ABB\n")
    position, rotation = eval(line.ask("GRASP 1\n"))
    line.ask("DIALECT FANUC\n")
    fanuc = [float(word) for word in line.ask("GRASP 1\n").split()]
    check(all(abs(1e3 * u - p) < 2e-3 and abs(p - f) < 2e-3 for u, p, f in zip(ur[3:6], position, fanuc[3:6])),
          f"the dialects say different places: {ur[3:6]} {position} {fanuc[3:6]}")
    check(same(rotation_of_vector(ur[6:9]), rotation) and same(rotation_of_angles(fanuc[8], fanuc[7], fanuc[6]), rotation),
          f"the dialects say different turns: {ur[6:9]} {rotation} {fanuc[6:9]}")
    service.close()
finally:
    if service.process.poll() is None:
        service.process.kill()
print("UR, ABB, KUKA, FANUC, Python and ROS 2 have picked the part")
