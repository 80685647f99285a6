// Reads lines "a b sum difference product less least most" (hexadecimal) and compares; NaN equals NaN.
module operators_bench;
  reg [31:0] a, b, sum, difference, product, least, most;
  reg less;
  wire [31:0] sum_y, difference_y, product_y, least_y, most_y;
  wire less_y;
  operators under_test(.a(a), .b(b), .sum(sum_y), .difference(difference_y), .product(product_y), .less(less_y),
                       .least(least_y), .most(most_y));
  integer file, read, lines, wrong;
  function same(input [31:0] x, input [31:0] y);
    same = x === y || (x[30:23] == 8'hff && x[22:0] != 0 && y[30:23] == 8'hff && y[22:0] != 0);
  endfunction
  initial begin
    file = $fopen("vectors.hex", "r");
    lines = 0;
    wrong = 0;
    read = $fscanf(file, "%h %h %h %h %h %h %h %h\n", a, b, sum, difference, product, less, least, most);
    while (read == 8) begin
      #1;
      lines = lines + 1;
      if (!same(sum, sum_y) || !same(difference, difference_y) || !same(product, product_y) || less !== less_y ||
          !same(least, least_y) || !same(most, most_y)) begin
        wrong = wrong + 1;
        if (wrong < 10) $display("wrong: %h %h: %h %h %h %h", a, b, sum_y, difference_y, product_y, less_y);
      end
      read = $fscanf(file, "%h %h %h %h %h %h %h %h\n", a, b, sum, difference, product, less, least, most);
    end
    $display("%0d vectors, %0d wrong", lines, wrong);
    $finish;
  end
endmodule
