#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 node: publishes the parts of the last scanned object as MoveIt collision objects in the frame robot_base."""
import socket

import rclpy
from geometry_msgs.msg import Point, Pose, Quaternion
from moveit_msgs.msg import CollisionObject
from rclpy.node import Node
from shape_msgs.msg import SolidPrimitive


def ask(lines, question):
    lines.write(question + "\n")
    lines.flush()
    return [float(word) for word in lines.readline().split()]


class Geond(Node):
    def __init__(self):
        super().__init__("geond")
        host = self.declare_parameter("host", "127.0.0.1").value
        port = self.declare_parameter("port", 7110).value
        self.lines = socket.create_connection((host, port)).makefile("rw", newline="\n")
        ask(self.lines, "DIALECT PLAIN")
        self.publisher = self.create_publisher(CollisionObject, "collision_object", 10)
        self.create_timer(1.0, self.publish)
        self.scan = None

    def publish(self):
        found = ask(self.lines, "OBJECT")
        if found[0] != 0 or found[17] == self.scan:
            return
        self.scan = found[17]
        for n in range(1, int(found[2]) + 1):
            p = ask(self.lines, f"PART {n}")
            # A box round the part, in metres; MoveIt's own primitives know no tapered or bent shapes.
            box = SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[2e-3 * size for size in p[10:13]])
            pose = Pose(position=Point(x=p[3] / 1e3, y=p[4] / 1e3, z=p[5] / 1e3),
                        orientation=Quaternion(w=p[6], x=p[7], y=p[8], z=p[9]))
            message = CollisionObject(id=f"part_{n}", primitives=[box], primitive_poses=[pose], operation=CollisionObject.ADD)
            message.header.frame_id = "robot_base"
            self.publisher.publish(message)


rclpy.init()
rclpy.spin(Geond())
