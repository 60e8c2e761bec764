"""What single lessons refuse."""

SENTENCES = (
    ("This sensor does not see every state, so the formula for L fails; turn the sensor.",
     "该传感器看不到全部状态，L 的公式不成立；请转动传感器。"),
    ("The run left every scale while the recursive filter settled; bring the gain m nearer to 1.",
     "递推滤波器收敛之前，运行已超出一切量级；请把增益 m 调近 1。"),
    ("The plant has left the region where its equations hold; start it nearer to rest.",
     "对象离开了方程成立的区域；请从更靠近静止处开始。"),
    ("The ceiling needs one unstable eigenvalue; this plant has {}.", "求上限要求恰有一个不稳定特征值，该对象有 {} 个；请换一个对象。"),
)
