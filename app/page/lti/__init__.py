"""Let learning platforms open lessons by LTI 1.3, choose one by deep linking, and take points back."""
