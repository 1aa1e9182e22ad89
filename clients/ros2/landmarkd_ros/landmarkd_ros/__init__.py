"""landmarkd as a ROS 2 node: `images` and `messages` map between its terms and ROS's, `node` is the node."""
